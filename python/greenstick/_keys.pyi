# Written by `cargo xtask generate`; change the declarations, not this file.
"""The keys of a recipe with their types."""

from collections.abc import Sequence
from typing import Any, Literal, TypedDict, overload

from numpy.typing import NDArray

class RequestKeys(TypedDict, total=False):
    """What a request may be given by keyword."""

    input: str | float | None
    unit: Literal["mm", "cm", "m"] | None
    every: float | str | None
    texture_size: int | str
    as_scan: bool
    no_outliers: bool
    outliers: float | str
    no_isolated: bool
    isolated: float | str
    no_duplicates: bool
    all_finite: bool
    spacing: float | str
    bark_only: bool
    least_cover: float | str
    pith: str | float | None
    kind: Literal["round", "board", "dowel", "pole"] | None
    eccentricity_onset: float | str | None
    slope_of_grain: float | str
    annual_rings: int | str | None
    ring_resolution: int | str
    ring_radii: Sequence[float] | NDArray[Any] | str | None
    ring_widths: Sequence[float] | NDArray[Any] | str | None
    ring_shares: Sequence[float] | NDArray[Any] | str | None
    rings_by: Literal["field", "erosion"]
    schedule: Literal["alternating", "figure-6", "eccentric"] | None
    kernels: str | float | None
    inner_circle: float | str | None
    at: str | float
    triangles: int | str | None
    part: float | str
    part_clear: bool
    fray: float | str
    species: str | float | None
    moisture: float | str | None
    sapwood_color: str | float | None
    heartwood_color: str | float | None
    bark_color: str | float | None
    latewood_contrast: float | str | None
    picture_size: str | float
    samples: int | str
    draft: bool
    view: str | float | None
    camera: str | float | None
    close_up: float | str | None
    ground: Literal["plain", "bench", "concrete", "litter"] | None
    depth_of_field: float | str | None
    film_grain: float | str | None
    lens_softness: float | str | None
    coin: bool
    chips: bool
    diameter: float | str
    rings: int | str
    sectors: int | str
    inclination: float | str
    inclination_direction: float | str
    seed: int | str
    pith_proportion: float | str
    heartwood_proportion: float | str
    phloem_proportion: float | str
    surface: Literal["smooth", "fibrous"]
    thorn_shaft: float | str
    size_effect: float | str
    bundle_aspect: float | str
    slab_count: int | str
    sliver_count: int | str
    slab_height: float | str
    sliver_height: float | str
    fibre_height: float | str
    fuzz: float | str
    splinter_lean: float | str | None
    splinter_snap: float | str | None
    step_height: float | str
    split: float | str
    compression_shelf: float | str
    compression_height: float | str
    bark_offset: float | str
    bark_height: float | str
    bark_strips: int | str
    hang: float | str
    spiral_angle: float | str

class RequestAttributes:
    """The keys of a request, as attributes and in brackets."""

    @property
    def input(self) -> str | None:
        """The mesh or point cloud that is broken; without it, the branch that comes with the program. A relative name starts from the folder of the file that it stands in."""
    @input.setter
    def input(self, value: str | float | None) -> None: ...
    @property
    def unit(self) -> Literal["mm", "cm", "m"] | None:
        """Unit of length in the input, where its format has none; also of the output."""
    @unit.setter
    def unit(self, value: Literal["mm", "cm", "m"] | None) -> None: ...
    @property
    def every(self) -> float | None:
        """Break it again and again, at every multiple of this length from the stem's base where it is free; the place of the break then only says which stem. Unit: metre."""
    @every.setter
    def every(self, value: float | str | None) -> None: ...
    @property
    def texture_size(self) -> int:
        """Width of the baked textures of the wood inside, pixels."""
    @texture_size.setter
    def texture_size(self, value: int | str) -> None: ...
    @property
    def as_scan(self) -> bool:
        """Treat a mesh as a scan: its bark is reconstructed and its holes are closed."""
    @as_scan.setter
    def as_scan(self, value: bool) -> None: ...
    @property
    def no_outliers(self) -> bool:
        """Keep points farther from their neighbours than the others are from theirs."""
    @no_outliers.setter
    def no_outliers(self, value: bool) -> None: ...
    @property
    def outliers(self) -> float:
        """Drop points whose mean distance to their neighbours exceeds the cloud's by this many standard deviations. Unit: one."""
    @outliers.setter
    def outliers(self, value: float | str) -> None: ...
    @property
    def no_isolated(self) -> bool:
        """Keep points without others near them."""
    @no_isolated.setter
    def no_isolated(self, value: bool) -> None: ...
    @property
    def isolated(self) -> float:
        """Drop points without two others within this many spacings of the cloud. Unit: one."""
    @isolated.setter
    def isolated(self, value: float | str) -> None: ...
    @property
    def no_duplicates(self) -> bool:
        """Keep points at equal positions."""
    @no_duplicates.setter
    def no_duplicates(self, value: bool) -> None: ...
    @property
    def all_finite(self) -> bool:
        """Refuse points whose coordinates are not finite instead of dropping them."""
    @all_finite.setter
    def all_finite(self, value: bool) -> None: ...
    @property
    def spacing(self) -> float:
        """Thin the cloud to this spacing; 0 leaves it as it is. Unit: metre."""
    @spacing.setter
    def spacing(self, value: float | str) -> None: ...
    @property
    def bark_only(self) -> bool:
        """Cut off the points of a fracture surface and keep the bark."""
    @bark_only.setter
    def bark_only(self, value: bool) -> None: ...
    @property
    def least_cover(self) -> float:
        """Share of the girth that must have been seen, along the metre of the location and those used beside it. Unit: fraction."""
    @least_cover.setter
    def least_cover(self, value: float | str) -> None: ...
    @property
    def pith(self) -> str | None:
        """Pith of the stem: x,y,z in the world, or x,y in the section from its middle (of sawn wood, half-way along it); 'auto' estimates it."""
    @pith.setter
    def pith(self, value: str | float | None) -> None: ...
    @property
    def kind(self) -> Literal["round", "board", "dowel", "pole"] | None:
        """What the stem is; 'auto' tells boards from round stems by their section. A round one has bark, unless it is straight, of one thickness and without a texture: then it is a dowel, or a pole where it is thicker than 6 cm."""
    @kind.setter
    def kind(self, value: Literal["round", "board", "dowel", "pole"] | None) -> None: ...
    @property
    def eccentricity_onset(self) -> float | None:
        """Share of the radius at which a stem that is eccentric began to lean: rings within are round about the pith, rings beyond are wider on one side, all by the same share. 'auto' is the usual one of such an outline; points on a few rings decide it. Unit: fraction."""
    @eccentricity_onset.setter
    def eccentricity_onset(self, value: float | str | None) -> None: ...
    @property
    def slope_of_grain(self) -> float:
        """Slope of grain of sawn wood: how far its fibres run across it per length, on average, with waves about that. 0 is straight-grained. Flat-sawn faces show it as arches (cathedral figure). That of a round stem follows its bark. Unit: fraction."""
    @slope_of_grain.setter
    def slope_of_grain(self, value: float | str) -> None: ...
    @property
    def annual_rings(self) -> int | None:
        """Annual rings of even width; 'auto' makes as many as usual, of widths that differ from year to year. An erosion makes its own."""
    @annual_rings.setter
    def annual_rings(self, value: int | str | None) -> None: ...
    @property
    def ring_resolution(self) -> int:
        """Pixels along each side of the section in which rings are eroded."""
    @ring_resolution.setter
    def ring_resolution(self, value: int | str) -> None: ...
    @property
    def ring_radii(self) -> list[float] | None:
        """Mean radii of the rings about the pith, from the pith outwards."""
    @ring_radii.setter
    def ring_radii(self, value: Sequence[float] | NDArray[Any] | str | None) -> None: ...
    @property
    def ring_widths(self) -> list[float] | None:
        """Mean widths of the rings, from the pith outwards, as a climate series has them. What remains of the radius lies outside the last one."""
    @ring_widths.setter
    def ring_widths(self, value: Sequence[float] | NDArray[Any] | str | None) -> None: ...
    @property
    def ring_shares(self) -> list[float] | None:
        """Mean radii of the rings as shares of the section's, from the pith outwards: the rings of another section."""
    @ring_shares.setter
    def ring_shares(self, value: Sequence[float] | NDArray[Any] | str | None) -> None: ...
    @property
    def rings_by(self) -> Literal["field", "erosion"]:
        """Where rings come from."""
    @rings_by.setter
    def rings_by(self, value: Literal["field", "erosion"]) -> None: ...
    @property
    def schedule(self) -> Literal["alternating", "figure-6", "eccentric"] | None:
        """Kernels of the erosion; 'auto' is alternating."""
    @schedule.setter
    def schedule(self, value: Literal["alternating", "figure-6", "eccentric"] | None) -> None: ...
    @property
    def kernels(self) -> str | None:
        """Custom kernels, from the bark inwards: rings with commas between them, in each latewood and earlywood with a slash between them, such as 4*3/5,3/7; a kernel is K or WxH pixels, then optionally its offset +X+Y and tM, the threshold. The last ring repeats."""
    @kernels.setter
    def kernels(self, value: str | float | None) -> None: ...
    @property
    def inner_circle(self) -> float | None:
        """Also erode from a circle about the pith outwards, until both fronts meet: its radius as a share of the section's mean one, as in the publication's Fig. 7. With any kernels, eccentric ones included. Unit: fraction."""
    @inner_circle.setter
    def inner_circle(self, value: float | str | None) -> None: ...
    @property
    def at(self) -> str:
        """Where to break it: a fraction of the stem's length from its base, 0 to 1, a length from its base, or a point in the world, which picks the limb that is nearest."""
    @at.setter
    def at(self, value: str | float) -> None: ...
    @property
    def triangles(self) -> int | None:
        """The most triangles that the pieces together may have beyond those of the stem that is broken. Where they would have more, the face has fewer rings and sectors, and spiral grain fewer levels."""
    @triangles.setter
    def triangles(self, value: int | str | None) -> None: ...
    @property
    def part(self) -> float:
        """Move the pieces apart by this length, along the grain. A piece that hangs on stays where it is. Unit: metre."""
    @part.setter
    def part(self, value: float | str) -> None: ...
    @property
    def part_clear(self) -> bool:
        """Move them farther than that where their splinters would still lie in each other."""
    @part_clear.setter
    def part_clear(self, value: bool) -> None: ...
    @property
    def fray(self) -> float:
        """Bend thorns and tear some loose: 0 not at all, 1 badly. Unit: one."""
    @fray.setter
    def fray(self, value: float | str) -> None: ...
    @property
    def species(self) -> str | None:
        """Species, by common or scientific name. It decides the height of the broken face and the shrinkage that cracks open by."""
    @species.setter
    def species(self, value: str | float | None) -> None: ...
    @property
    def moisture(self) -> float | None:
        """Moisture content, percent of the oven-dry mass: 12 is air-dry, 30 and more is green. Unit: percent."""
    @moisture.setter
    def moisture(self, value: float | str | None) -> None: ...
    @property
    def sapwood_color(self) -> str | None:
        """Colour of the earlywood of the sapwood, as a photograph shows it: `#e0c296`."""
    @sapwood_color.setter
    def sapwood_color(self, value: str | float | None) -> None: ...
    @property
    def heartwood_color(self) -> str | None:
        """Colour of the earlywood of the heartwood."""
    @heartwood_color.setter
    def heartwood_color(self, value: str | float | None) -> None: ...
    @property
    def bark_color(self) -> str | None:
        """Colour of the ridges of the bark; furrows and torn bark are darker shades of it. Bark that the input shows keeps its own."""
    @bark_color.setter
    def bark_color(self, value: str | float | None) -> None: ...
    @property
    def latewood_contrast(self) -> float | None:
        """How much darker latewood is than earlywood: 0 not at all, 1 as dark as in pine. Unit: one."""
    @latewood_contrast.setter
    def latewood_contrast(self, value: float | str | None) -> None: ...
    @property
    def picture_size(self) -> str:
        """Size of the picture, pixels."""
    @picture_size.setter
    def picture_size(self, value: str | float) -> None: ...
    @property
    def samples(self) -> int:
        """Most camera rays for a pixel of the picture; those without an edge or fine detail take fewer. Light takes an eighth as many."""
    @samples.setter
    def samples(self, value: int | str) -> None: ...
    @property
    def draft(self) -> bool:
        """Renders a rough picture quickly: at a third of the width and height, with at most four camera rays for a pixel, enlarged, and without grain unless it is asked for."""
    @draft.setter
    def draft(self, value: bool) -> None: ...
    @property
    def view(self) -> str | None:
        """Direction from which the picture is taken, degrees; 'auto' chooses one that suits."""
    @view.setter
    def view(self, value: str | float | None) -> None: ...
    @property
    def camera(self) -> str | None:
        """Where the camera is and where it looks, m in the coordinates of what is shown, and its field of view across the shorter side, degrees (25): it stays there over all frames of a film, whatever `view` and `close_up` say. 'auto' places one that suits."""
    @camera.setter
    def camera(self, value: str | float | None) -> None: ...
    @property
    def close_up(self) -> float | None:
        """How much is shown around the broken faces, of several breaks those of the first, in diameters of the stem; 'auto' shows everything, or nine diameters of simulated wood in which the break would be too small to be seen. Unit: one."""
    @close_up.setter
    def close_up(self, value: float | str | None) -> None: ...
    @property
    def ground(self) -> Literal["plain", "bench", "concrete", "litter"] | None:
        """What the wood stands on; 'auto' puts broken and simulated wood on a floor of concrete, what is large on fallen leaves, and anything else before the plain backdrop."""
    @ground.setter
    def ground(self, value: Literal["plain", "bench", "concrete", "litter"] | None) -> None: ...
    @property
    def depth_of_field(self) -> float | None:
        """How much what lies before and behind the focus is blurred: 0 not at all, 1 as by a lens from near; 'auto' is that of an aperture of 24 mm on a ground, which blurs what is behind a branch and hardly anything behind a trunk, and nothing before the plain backdrop. Unit: one."""
    @depth_of_field.setter
    def depth_of_field(self, value: float | str | None) -> None: ...
    @property
    def film_grain(self) -> float | None:
        """Grain of the picture, the noise of a sensor: 0 for none, 1 for that of very little light; 'auto' is a little on a ground and none before the plain backdrop. Pictures less than 900 pixels high have less. Unit: one."""
    @film_grain.setter
    def film_grain(self, value: float | str | None) -> None: ...
    @property
    def lens_softness(self) -> float | None:
        """Softness of the lens: 0 for none, 1 for that of a poor one, which spreads each point by a pixel and a half and has a glow about what is bright; 'auto' is a little on a ground and none before the plain backdrop. Pictures less than 900 pixels high are spread less. Unit: one."""
    @lens_softness.setter
    def lens_softness(self, value: float | str | None) -> None: ...
    @property
    def coin(self) -> bool:
        """Lays a coin of one euro, 23 mm wide, in front of the wood, for scale."""
    @coin.setter
    def coin(self, value: bool) -> None: ...
    @property
    def chips(self) -> bool:
        """Strews chips of torn wood about a break."""
    @chips.setter
    def chips(self, value: bool) -> None: ...
    @property
    def diameter(self) -> float:
        """The diameter that noise is laid out for, in cm as in Table 2. The stem's own size comes from its mesh: with 1 here the pattern on any stem is that of a branch of 1 cm; with 0 it is laid out in true metres on the stem as it is. A branch made from nothing has this diameter. Unit: centimetre."""
    @diameter.setter
    def diameter(self, value: float | str) -> None: ...
    @property
    def rings(self) -> int:
        """Concentric circles on the section."""
    @rings.setter
    def rings(self, value: int | str) -> None: ...
    @property
    def sectors(self) -> int:
        """Sectors of the section."""
    @sectors.setter
    def sectors(self, value: int | str) -> None: ...
    @property
    def inclination(self) -> float:
        """Inclination of the broken face against the section. Unit: degree."""
    @inclination.setter
    def inclination(self, value: float | str) -> None: ...
    @property
    def inclination_direction(self) -> float:
        """Direction in which the inclined face rises. Unit: degree."""
    @inclination_direction.setter
    def inclination_direction(self, value: float | str) -> None: ...
    @property
    def seed(self) -> int:
        """Which random break of all those with these parameters. Every stem breaks differently with the same seed."""
    @seed.setter
    def seed(self, value: int | str) -> None: ...
    @property
    def pith_proportion(self) -> float:
        """Part of the radius that is pith. Unit: fraction."""
    @pith_proportion.setter
    def pith_proportion(self, value: float | str) -> None: ...
    @property
    def heartwood_proportion(self) -> float:
        """Part of the radius that is heartwood. Unit: fraction."""
    @heartwood_proportion.setter
    def heartwood_proportion(self, value: float | str) -> None: ...
    @property
    def phloem_proportion(self) -> float:
        """Part of the radius that is phloem. What is left is sapwood, and the outermost ring is bark. Unit: fraction."""
    @phloem_proportion.setter
    def phloem_proportion(self, value: float | str) -> None: ...
    @property
    def surface(self) -> Literal["smooth", "fibrous"]:
        """What the face is made of: 'smooth' is the height field of the paper, 'fibrous' has bundles with walls along the grain."""
    @surface.setter
    def surface(self, value: Literal["smooth", "fibrous"]) -> None: ...
    @property
    def thorn_shaft(self) -> float:
        """Part of a thorn's height that is a slender prism; the rest is an irregular pyramid (section 3.5). Unit: fraction."""
    @thorn_shaft.setter
    def thorn_shaft(self, value: float | str) -> None: ...
    @property
    def size_effect(self) -> float:
        """How much the counts and heights below, which are those of a stem 4 cm thick, follow the size of the stem: 0 not at all, so that a trunk breaks like a twig seen from near; 1 as wood does, with more slivers in a trunk, which are shorter against its radius. A thick stem then has up to 1.4 times the rings and sectors. Unit: fraction."""
    @size_effect.setter
    def size_effect(self, value: float | str) -> None: ...
    @property
    def bundle_aspect(self) -> float:
        """Width of a sliver, a group of fibre bundles that ended together, along the ring over its thickness across it, at most: splinters are flat. Unit: one."""
    @bundle_aspect.setter
    def bundle_aspect(self, value: float | str) -> None: ...
    @property
    def slab_count(self) -> int:
        """Slabs, the coarsest pieces: bounded by rings and rays."""
    @slab_count.setter
    def slab_count(self, value: int | str) -> None: ...
    @property
    def sliver_count(self) -> int:
        """Slivers, the pieces that slabs split into: groups of fibre bundles."""
    @sliver_count.setter
    def sliver_count(self, value: int | str) -> None: ...
    @property
    def slab_height(self) -> float:
        """Height by which slabs differ. Unit: radius."""
    @slab_height.setter
    def slab_height(self, value: float | str) -> None: ...
    @property
    def sliver_height(self) -> float:
        """Height by which the slivers of a slab differ. Unit: radius."""
    @sliver_height.setter
    def sliver_height(self, value: float | str) -> None: ...
    @property
    def fibre_height(self) -> float:
        """Height of the fur of fine fibres on the tips. Unit: radius."""
    @fibre_height.setter
    def fibre_height(self, value: float | str) -> None: ...
    @property
    def fuzz(self) -> float:
        """Strands of torn fibre on the broken face, along the sides of its splinters and on their edges, and, on pieces that are moved apart, at the ends of short breaks, too: 0 none, 1 as many as there can be. They are thin meshes of their own beside the pieces, which files of a single mesh leave out. Unit: fraction."""
    @fuzz.setter
    def fuzz(self, value: float | str) -> None: ...
    @property
    def splinter_lean(self) -> float | None:
        """Mean angle by which slender splinters lean from the grain, each to a side of its own, as torn wood springs apart: not at the root, more and more towards the tip, thick ones less. Each half is bent by itself after it was cut, which changes volumes by some hundredths of a percent; with 0 here and for `splinter_snap` the halves fit exactly. 'auto' is 8° where pieces are moved apart or hang, and 0 where they lie in each other. Unit: degree."""
    @splinter_lean.setter
    def splinter_lean(self, value: float | str | None) -> None: ...
    @property
    def splinter_snap(self) -> float | None:
        """Share of the slender splinters that snapped on their way and hang to one side by the fibres that still hold. Where there is no room for that, they stay as they are. 'auto' is 0.2 where pieces are moved apart or hang, and 0 where they lie in each other. Unit: fraction."""
    @splinter_snap.setter
    def splinter_snap(self, value: float | str | None) -> None: ...
    @property
    def step_height(self) -> float:
        """Height of the steps between neighbouring rings where the wood breaks brittle. The shear-lag length of the species over the radius is its natural value. Unit: radius."""
    @step_height.setter
    def step_height(self, value: float | str) -> None: ...
    @property
    def split(self) -> float:
        """Depth of the split along the grain between the tension and the compression side. Unit: radius."""
    @split.setter
    def split(self, value: float | str) -> None: ...
    @property
    def compression_shelf(self) -> float:
        """Part of the section, from the compression side, that broke as a blunt shelf. Unit: fraction."""
    @compression_shelf.setter
    def compression_shelf(self, value: float | str) -> None: ...
    @property
    def compression_height(self) -> float:
        """Height of the crumpled steps on that shelf. Unit: radius."""
    @compression_height.setter
    def compression_height(self, value: float | str) -> None: ...
    @property
    def bark_offset(self) -> float:
        """Height at which the bark broke, against the wood under it: above zero it stands over, below it is torn back. Unit: radius."""
    @bark_offset.setter
    def bark_offset(self, value: float | str) -> None: ...
    @property
    def bark_height(self) -> float:
        """Height by which the strips of bark differ: some stand over the wood as flaps, some are peeled back from it. Unit: radius."""
    @bark_height.setter
    def bark_height(self, value: float | str) -> None: ...
    @property
    def bark_strips(self) -> int:
        """Strips that the bark tears into around the stem, along its furrows."""
    @bark_strips.setter
    def bark_strips(self, value: int | str) -> None: ...
    @property
    def hang(self) -> float:
        """Angle by which the upper piece turns about the bark of the compression side and hangs on it. The face keeps within the wedge that this opens. Unit: degree."""
    @hang.setter
    def hang(self, value: float | str) -> None: ...
    @property
    def spiral_angle(self) -> float:
        """Turn of the splinters about the axis, for breaks by twisting. Unit: degree_per_radius."""
    @spiral_angle.setter
    def spiral_angle(self, value: float | str) -> None: ...
    @overload
    def __getitem__(self, key: Literal[
        "schedule",
    ]) -> Literal["alternating", "figure-6", "eccentric"] | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "crack_groups.end",
    ]) -> Literal["break", "sawn", "base"]: ...
    @overload
    def __getitem__(self, key: Literal[
        "rings_by",
    ]) -> Literal["field", "erosion"]: ...
    @overload
    def __getitem__(self, key: Literal[
        "unit",
    ]) -> Literal["mm", "cm", "m"] | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "ground",
    ]) -> Literal["plain", "bench", "concrete", "litter"] | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "kind",
    ]) -> Literal["round", "board", "dowel", "pole"] | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "surface",
    ]) -> Literal["smooth", "fibrous"]: ...
    @overload
    def __getitem__(self, key: Literal[
        "as_scan", "no_outliers", "no_isolated", "no_duplicates", "all_finite", "bark_only", "part_clear",
        "draft", "coin", "chips", "heights.added",
    ]) -> bool: ...
    @overload
    def __getitem__(self, key: Literal[
        "outliers", "isolated", "spacing", "least_cover", "slope_of_grain", "part", "fray", "diameter",
        "inclination", "inclination_direction", "pith_proportion", "heartwood_proportion", "phloem_proportion",
        "thorn_shaft", "size_effect", "bundle_aspect", "slab_height", "sliver_height", "fibre_height", "fuzz",
        "step_height", "split", "compression_shelf", "compression_height", "bark_offset", "bark_height",
        "hang", "spiral_angle", "pith.perlin_amplitude", "pith.perlin_frequency", "pith.white_noise_amplitude",
        "pith.thorn_length", "pith.thorn_probability", "heartwood.perlin_amplitude",
        "heartwood.perlin_frequency", "heartwood.white_noise_amplitude", "heartwood.thorn_length",
        "heartwood.thorn_probability", "sapwood.perlin_amplitude", "sapwood.perlin_frequency",
        "sapwood.white_noise_amplitude", "sapwood.thorn_length", "sapwood.thorn_probability",
        "phloem.perlin_amplitude", "phloem.perlin_frequency", "phloem.white_noise_amplitude",
        "phloem.thorn_length", "phloem.thorn_probability", "bark.perlin_amplitude", "bark.perlin_frequency",
        "bark.white_noise_amplitude", "bark.thorn_length", "bark.thorn_probability", "high.height",
        "high.direction", "high.angle", "high.rings", "low.height", "low.direction", "low.angle", "low.rings",
        "ductile.thorn_length", "ductile.thorn_probability", "ductile.direction", "ductile.angle",
        "ductile.rings", "brittle.thorn_length", "brittle.thorn_probability", "crack_groups.distortion",
        "crack_groups.large.direction", "crack_groups.large.spacing", "crack_groups.large.jitter",
        "crack_groups.large.begin_min", "crack_groups.large.begin_max", "crack_groups.large.length_min",
        "crack_groups.large.length_max", "crack_groups.large.depth_min", "crack_groups.large.depth_max",
        "crack_groups.large.range_min", "crack_groups.large.range_max", "crack_groups.medium.direction",
        "crack_groups.medium.spacing", "crack_groups.medium.jitter", "crack_groups.medium.begin_min",
        "crack_groups.medium.begin_max", "crack_groups.medium.length_min", "crack_groups.medium.length_max",
        "crack_groups.medium.depth_min", "crack_groups.medium.depth_max", "crack_groups.medium.range_min",
        "crack_groups.medium.range_max", "crack_groups.small.direction", "crack_groups.small.spacing",
        "crack_groups.small.jitter", "crack_groups.small.begin_min", "crack_groups.small.begin_max",
        "crack_groups.small.length_min", "crack_groups.small.length_max", "crack_groups.small.depth_min",
        "crack_groups.small.depth_max", "crack_groups.small.range_min", "crack_groups.small.range_max",
    ]) -> float: ...
    @overload
    def __getitem__(self, key: Literal[
        "every", "eccentricity_onset", "inner_circle", "moisture", "latewood_contrast", "close_up",
        "depth_of_field", "film_grain", "lens_softness", "splinter_lean", "splinter_snap",
        "crack_groups.large.shrinkage", "crack_groups.medium.shrinkage", "crack_groups.small.shrinkage",
    ]) -> float | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "texture_size", "ring_resolution", "samples", "rings", "sectors", "seed", "slab_count", "sliver_count",
        "bark_strips", "pith.perlin_octaves", "pith.white_noise_octaves", "heartwood.perlin_octaves",
        "heartwood.white_noise_octaves", "sapwood.perlin_octaves", "sapwood.white_noise_octaves",
        "phloem.perlin_octaves", "phloem.white_noise_octaves", "bark.perlin_octaves",
        "bark.white_noise_octaves", "heights.sectors", "crack_groups.large.count", "crack_groups.medium.count",
        "crack_groups.small.count",
    ]) -> int: ...
    @overload
    def __getitem__(self, key: Literal[
        "annual_rings", "triangles",
    ]) -> int | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "heights.modes",
    ]) -> list[Literal["torn", "crushed", "split", "twisted", "unbroken"]]: ...
    @overload
    def __getitem__(self, key: Literal[
        "heights.values", "heights.splintering", "heights.between_rings", "heights.between_angles",
    ]) -> list[float]: ...
    @overload
    def __getitem__(self, key: Literal[
        "ring_radii", "ring_widths", "ring_shares",
    ]) -> list[float] | None: ...
    @overload
    def __getitem__(self, key: Literal[
        "at", "picture_size",
    ]) -> str: ...
    @overload
    def __getitem__(self, key: Literal[
        "input", "pith", "kernels", "species", "sapwood_color", "heartwood_color", "bark_color", "view",
        "camera",
    ]) -> str | None: ...
    @overload
    def __getitem__(self, key: str) -> Any: ...
    @overload
    def __setitem__(self, key: Literal[
        "schedule",
    ], value: Literal["alternating", "figure-6", "eccentric"] | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "crack_groups.end",
    ], value: Literal["break", "sawn", "base"]) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "rings_by",
    ], value: Literal["field", "erosion"]) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "unit",
    ], value: Literal["mm", "cm", "m"] | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "ground",
    ], value: Literal["plain", "bench", "concrete", "litter"] | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "kind",
    ], value: Literal["round", "board", "dowel", "pole"] | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "surface",
    ], value: Literal["smooth", "fibrous"]) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "as_scan", "no_outliers", "no_isolated", "no_duplicates", "all_finite", "bark_only", "part_clear",
        "draft", "coin", "chips", "heights.added",
    ], value: bool) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "outliers", "isolated", "spacing", "least_cover", "slope_of_grain", "part", "fray", "diameter",
        "inclination", "inclination_direction", "pith_proportion", "heartwood_proportion", "phloem_proportion",
        "thorn_shaft", "size_effect", "bundle_aspect", "slab_height", "sliver_height", "fibre_height", "fuzz",
        "step_height", "split", "compression_shelf", "compression_height", "bark_offset", "bark_height",
        "hang", "spiral_angle", "pith.perlin_amplitude", "pith.perlin_frequency", "pith.white_noise_amplitude",
        "pith.thorn_length", "pith.thorn_probability", "heartwood.perlin_amplitude",
        "heartwood.perlin_frequency", "heartwood.white_noise_amplitude", "heartwood.thorn_length",
        "heartwood.thorn_probability", "sapwood.perlin_amplitude", "sapwood.perlin_frequency",
        "sapwood.white_noise_amplitude", "sapwood.thorn_length", "sapwood.thorn_probability",
        "phloem.perlin_amplitude", "phloem.perlin_frequency", "phloem.white_noise_amplitude",
        "phloem.thorn_length", "phloem.thorn_probability", "bark.perlin_amplitude", "bark.perlin_frequency",
        "bark.white_noise_amplitude", "bark.thorn_length", "bark.thorn_probability", "high.height",
        "high.direction", "high.angle", "high.rings", "low.height", "low.direction", "low.angle", "low.rings",
        "ductile.thorn_length", "ductile.thorn_probability", "ductile.direction", "ductile.angle",
        "ductile.rings", "brittle.thorn_length", "brittle.thorn_probability", "crack_groups.distortion",
        "crack_groups.large.direction", "crack_groups.large.spacing", "crack_groups.large.jitter",
        "crack_groups.large.begin_min", "crack_groups.large.begin_max", "crack_groups.large.length_min",
        "crack_groups.large.length_max", "crack_groups.large.depth_min", "crack_groups.large.depth_max",
        "crack_groups.large.range_min", "crack_groups.large.range_max", "crack_groups.medium.direction",
        "crack_groups.medium.spacing", "crack_groups.medium.jitter", "crack_groups.medium.begin_min",
        "crack_groups.medium.begin_max", "crack_groups.medium.length_min", "crack_groups.medium.length_max",
        "crack_groups.medium.depth_min", "crack_groups.medium.depth_max", "crack_groups.medium.range_min",
        "crack_groups.medium.range_max", "crack_groups.small.direction", "crack_groups.small.spacing",
        "crack_groups.small.jitter", "crack_groups.small.begin_min", "crack_groups.small.begin_max",
        "crack_groups.small.length_min", "crack_groups.small.length_max", "crack_groups.small.depth_min",
        "crack_groups.small.depth_max", "crack_groups.small.range_min", "crack_groups.small.range_max",
    ], value: float | str) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "every", "eccentricity_onset", "inner_circle", "moisture", "latewood_contrast", "close_up",
        "depth_of_field", "film_grain", "lens_softness", "splinter_lean", "splinter_snap",
        "crack_groups.large.shrinkage", "crack_groups.medium.shrinkage", "crack_groups.small.shrinkage",
    ], value: float | str | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "texture_size", "ring_resolution", "samples", "rings", "sectors", "seed", "slab_count", "sliver_count",
        "bark_strips", "pith.perlin_octaves", "pith.white_noise_octaves", "heartwood.perlin_octaves",
        "heartwood.white_noise_octaves", "sapwood.perlin_octaves", "sapwood.white_noise_octaves",
        "phloem.perlin_octaves", "phloem.white_noise_octaves", "bark.perlin_octaves",
        "bark.white_noise_octaves", "heights.sectors", "crack_groups.large.count", "crack_groups.medium.count",
        "crack_groups.small.count",
    ], value: int | str) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "annual_rings", "triangles",
    ], value: int | str | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "heights.modes",
    ], value: Sequence[Literal["torn", "crushed", "split", "twisted", "unbroken"]] | NDArray[Any] | str) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "heights.values", "heights.splintering", "heights.between_rings", "heights.between_angles",
    ], value: Sequence[float] | NDArray[Any] | str) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "ring_radii", "ring_widths", "ring_shares",
    ], value: Sequence[float] | NDArray[Any] | str | None) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "at", "picture_size",
    ], value: str | float) -> None: ...
    @overload
    def __setitem__(self, key: Literal[
        "input", "pith", "kernels", "species", "sapwood_color", "heartwood_color", "bark_color", "view",
        "camera",
    ], value: str | float | None) -> None: ...
    @overload
    def __setitem__(self, key: str, value: object) -> None: ...
