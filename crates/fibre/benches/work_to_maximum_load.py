"""Work to maximum load of solid wood in bending by section analysis, beside the tables, under several laws of stress.

pip install numpy scipy; python3 crates/fibre/benches/work_to_maximum_load.py, in the repository's root.
For each species the section has the table's modulus (raised by 10 % for shear), crushing strength and modulus of rupture: what is left
open, the strength in tension, follows. The specimen is that of the tables: 50 × 50 mm on a span of 710 mm with the load in the middle.
"""

import csv

import numpy
from scipy.optimize import brentq
from scipy.stats import spearmanr

TABLE = "crates/wood/data/usda_table_5_3a_mechanical.csv"
SIDE, SPAN = 0.05, 0.71  # m
TRUE_OVER_BENDING_MODULUS = 1.1
MODULUS_OVER_SHEAR = 16
STRIPS = 120

# Strains are over that at which wood of the crushing strength would yield if it were linear until there, stresses over that strength.
HEIGHTS = (numpy.arange(STRIPS) + 0.5) / STRIPS - 0.5
CURVATURES = numpy.geomspace(0.3, 40, 110)
TENSION = numpy.geomspace(1, 30, 26)


def yields(strain):
    """Linear, then as strong as it is."""
    return numpy.minimum(strain, 1)


def gradual(exponent, part):
    """Ramberg and Osgood 1943: ε = s + part s^exponent, up to the crushing strength."""
    stress = numpy.linspace(0, 1, 400)
    strain = stress + part * stress**exponent
    return lambda e: numpy.interp(e, strain, stress)


def bundle(exponent, limit):
    """Linear fibres whose strengths are of a Weibull distribution (Daniels 1945); one strength where the exponent is infinite."""
    if exponent == numpy.inf:
        return lambda e: numpy.where(e < limit, e, 0)
    return lambda e: e * numpy.exp(-((e / limit) ** exponent))


def bend(compression, tension):
    """Curvatures and moments of a section until the moment falls."""
    moments, curvatures = [0.0], [0.0]
    for curvature in CURVATURES:

        def stress(axis):
            strain = curvature * (HEIGHTS - axis)
            return numpy.where(strain > 0, tension(numpy.maximum(strain, 0)), -compression(numpy.maximum(-strain, 0)))

        axes = numpy.linspace(-0.5, 0.5, 41)
        forces = numpy.array([stress(axis).mean() for axis in axes])
        changes = numpy.nonzero((forces[:-1] > 0) & (forces[1:] <= 0))[0]
        if not len(changes):
            break
        axis = brentq(lambda a: stress(a).mean(), axes[changes[0]], axes[changes[0] + 1], xtol=1e-6)
        moment = (stress(axis) * HEIGHTS).mean()
        if moment < moments[-1]:
            break
        moments.append(moment)
        curvatures.append(curvature)
    return numpy.array(curvatures), numpy.array(moments)


def work(curvatures, moments):
    """Work per volume of the span, over fc²/E, when the moment in the middle is the greatest."""
    greatest = moments[-1]
    energy = numpy.concatenate([[0], numpy.cumsum(0.5 * (moments[1:] + moments[:-1]) * numpy.diff(curvatures))])
    along = (numpy.arange(300) + 0.5) / 300
    bending = numpy.interp(along * greatest, moments, energy).mean()
    force = 0.5 * 4 * greatest * SIDE / SPAN
    return bending + 0.5 * 1.2 * MODULUS_OVER_SHEAR * force**2


def compare(compression, exponent, moisture):
    """Ratios of the work to the table's, and their rank correlation."""
    bent = [bend(compression, bundle(exponent, limit)) for limit in TENSION]
    greatest = [moments[-1] for _, moments in bent]
    works = [work(*one) for one in bent]
    ours, tables = [], []
    for row in csv.DictReader(open(TABLE, encoding="utf-8")):
        keys = ("modulus_of_elasticity_mpa", "compression_parallel_kpa", "modulus_of_rupture_kpa", "work_to_maximum_load_kj_m3")
        if not row["moisture"].lower().startswith(moisture) or not all(row[k] for k in keys):
            continue
        modulus, crushing, rupture, table = (float(row[k]) for k in keys)
        relative = numpy.interp(rupture / crushing / 6, greatest, works)
        ours.append(relative * crushing**2 / (TRUE_OVER_BENDING_MODULUS * modulus * 1e3))
        tables.append(table)
    return numpy.array(ours) / tables, spearmanr(ours, tables)[0]


COMPRESSIONS = {
    "yields at the crushing strength": yields,
    "gradual, n = 5, 0.5": gradual(5, 0.5),
    "gradual, n = 5, 1": gradual(5, 1),
}
print("| compression | tension | moisture | species | median | range | rank correlation |")
print("|---|---|---|---|---|---|---|")
for name, law in COMPRESSIONS.items():
    for exponent in (numpy.inf, 10, 4):
        for moisture in ("12%", "green"):
            ratios, rank = compare(law, exponent, moisture)
            fibres = "one strength" if exponent == numpy.inf else f"Weibull {exponent}"
            print(
                f"| {name} | {fibres} | {moisture} | {len(ratios)} | {numpy.median(ratios):.3f} "
                f"| {ratios.min():.2f} to {ratios.max():.2f} | {rank:.3f} |"
            )
