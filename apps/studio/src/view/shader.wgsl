// What the viewport shows: wood and bark as functions of their address, after greenstick's wood::appearance, and the
// input's own materials, in the light of greenstick's pictures: a large key light with shadow, a rim light, a sky, which surfaces also
// reflect.
// The figures are those of the pictures; only the hash behind them differs, as shaders have no 64-bit numbers.

struct Globals {
    view_projection: mat4x4<f32>,
    light_projection: mat4x4<f32>,
    eye: vec4<f32>,            // w: size of a pixel at a distance of 1
    up: vec4<f32>,             // w: what colours show
    key_direction: vec4<f32>,  // w: radius of the soft shadow in the shadow map
    rim_direction: vec4<f32>,
    background: vec4<f32>,     // w: 1 where the target is encoded by the card
    section: vec4<f32>,        // plane beyond which nothing is drawn
    flags: vec4<f32>,          // x: section on, y: by how much surfaces are lifted out of their own shadow, z: reach of shade
    forward: vec4<f32>,        // into the picture; w: radius of the scene
    right: vec4<f32>,
};

struct Wood {
    sapwood: vec4<f32>,
    latewood: vec4<f32>,
    heartwood: vec4<f32>,
    pith: vec4<f32>,
    phloem: vec4<f32>,
    cork: vec4<f32>,
    ridge: vec4<f32>,
    furrow: vec4<f32>,
    edges: vec4<f32>,    // radius, pith, heartwood, phloem
    rings: vec4<f32>,    // cork, contrast of latewood, its width, ring-porous
    vessels: vec4<f32>,  // diameter, contrast of rays, their height, lenticels
    square: vec4<f32>,   // least x and y of the ring field, its side, texels along a side
    bark: vec4<f32>,     // width and depth of furrows, whether a board, whether rings are in the field
    seed: vec4<u32>,
    middle: vec4<f32>,   // pith in the section
};

struct Surface {
    base: vec4<f32>,
    // metalness, roughness, kind (0 its own material, 1 wood, 2 skin of the stem), whether it has a texture
    kind: vec4<f32>,
    // scale and offset of texture coordinates
    texture_map: vec4<f32>,
    // sine and cosine of their turn
    turn: vec4<f32>,
    // the same of the relief; its strength, whether there is one
    relief_map: vec4<f32>,
    relief: vec4<f32>,
    // 0 opaque, 1 with holes, 2 blended; opacity below which there is a hole
    opacity: vec4<f32>,
};

@group(0) @binding(0) var<uniform> g: Globals;
@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var distances: texture_2d<f32>;
@group(1) @binding(0) var<uniform> wood: Wood;
@group(1) @binding(1) var ring_field: texture_2d<f32>;
@group(1) @binding(2) var ring_years: texture_2d<f32>;
@group(2) @binding(0) var<uniform> surface: Surface;
@group(2) @binding(1) var base_texture: texture_2d<f32>;
@group(2) @binding(2) var base_sampler: sampler;
@group(2) @binding(3) var relief_texture: texture_2d<f32>;
@group(2) @binding(4) var relief_sampler: sampler;

struct VertexIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) grain: vec4<f32>,
    @location(4) zone_piece: vec2<f32>,
};

struct Varying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) grain: vec4<f32>,
    @location(4) zone_piece: vec2<f32>,
};

@vertex
fn vertex_main(v: VertexIn) -> Varying {
    var out: Varying;
    out.clip = g.view_projection * vec4<f32>(v.position, 1.0);
    out.position = v.position;
    out.normal = v.normal;
    out.uv = v.uv;
    out.grain = v.grain;
    out.zone_piece = v.zone_piece;
    return out;
}

struct ShadowVarying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
};

@vertex
fn vertex_shadow(@location(0) position: vec3<f32>) -> ShadowVarying {
    var out: ShadowVarying;
    out.clip = g.light_projection * vec4<f32>(position, 1.0);
    out.position = position;
    return out;
}

fn is_cut_away(position: vec3<f32>) -> bool {
    return g.flags.x > 0.5 && dot(g.section.xyz, position) > g.section.w;
}

// What is cut away casts no shadow.
@fragment
fn fragment_shadow(v: ShadowVarying) {
    if (is_cut_away(v.position)) { discard; }
}

// How far into the picture each pixel is: WebGL 2 reads no depths, so that they are colours of three bytes.
@vertex
fn vertex_distance(@location(0) position: vec3<f32>) -> ShadowVarying {
    var out: ShadowVarying;
    out.clip = g.view_projection * vec4<f32>(position, 1.0);
    out.position = position;
    return out;
}

@fragment
fn fragment_distance(v: ShadowVarying) -> @location(0) vec4<f32> {
    if (is_cut_away(v.position)) { discard; }
    return coded_distance(v.position);
}

fn coded_distance(position: vec3<f32>) -> vec4<f32> {
    let part = clamp(0.5 + 0.5 * dot(position, g.forward.xyz) / g.forward.w, 0.0, 0.9999999);
    let bytes = floor(fract(part * vec3<f32>(1.0, 256.0, 65536.0)) * 256.0);
    return vec4<f32>(bytes / 255.0, 1.0);
}

// ---------------------------------------------------------------- textures, as glTF 2.0 has them

// Coordinates of a texture: scaled, turned, moved, as KHR_texture_transform says.
fn texture_place(uv: vec2<f32>, turn: vec2<f32>, map: vec4<f32>) -> vec2<f32> {
    let scaled = uv * map.xy;
    let turned = vec2<f32>(turn.y * scaled.x + turn.x * scaled.y, turn.y * scaled.y - turn.x * scaled.x);
    return turned + map.zw;
}

fn base_texel(uv: vec2<f32>) -> vec4<f32> {
    return textureSample(base_texture, base_sampler, texture_place(uv, surface.turn.xy, surface.texture_map));
}

// Whether light goes through a surface: through holes, and through what is more clear than not.
fn is_clear(opacity: f32) -> bool {
    return opacity * surface.base.w < select(0.5, surface.opacity.y, surface.opacity.x < 1.5);
}

struct HolesVarying {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) uv: vec2<f32>,
};

@vertex
fn vertex_shadow_with_holes(@location(0) position: vec3<f32>, @location(2) uv: vec2<f32>) -> HolesVarying {
    var out: HolesVarying;
    out.clip = g.light_projection * vec4<f32>(position, 1.0);
    out.position = position;
    out.uv = uv;
    return out;
}

@fragment
fn fragment_shadow_with_holes(v: HolesVarying) {
    let opacity = base_texel(v.uv).w;
    if (is_cut_away(v.position) || is_clear(opacity)) { discard; }
}

@vertex
fn vertex_distance_with_holes(@location(0) position: vec3<f32>, @location(2) uv: vec2<f32>) -> HolesVarying {
    var out: HolesVarying;
    out.clip = g.view_projection * vec4<f32>(position, 1.0);
    out.position = position;
    out.uv = uv;
    return out;
}

@fragment
fn fragment_distance_with_holes(v: HolesVarying) -> @location(0) vec4<f32> {
    let opacity = base_texel(v.uv).w;
    if (is_cut_away(v.position) || is_clear(opacity)) { discard; }
    return coded_distance(v.position);
}

// A normal tilted by a texel of a relief, whose x runs along u and whose y runs against v, which counts downwards; `du` and `dv` are
// how the coordinates rise along the surface.
fn tilted(normal: vec3<f32>, du: vec3<f32>, dv: vec3<f32>, texel: vec3<f32>) -> vec3<f32> {
    let right = flattened(du - dv * (dot(du, dv) / max(dot(dv, dv), 1e-20)), normal);
    let down = flattened(dv - du * (dot(dv, du) / max(dot(du, du), 1e-20)), normal);
    let lean = vec3<f32>((texel.xy * 2.0 - 1.0) * surface.relief.z, texel.z * 2.0 - 1.0);
    let tilt = right * lean.x - down * lean.y + normal * lean.z;
    return select(normal, normalize(tilt), dot(tilt, tilt) > 1e-12);
}

// A direction in the plane across a normal, of unit length; none where there is none.
fn flattened(direction: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let flat = direction - normal * dot(normal, direction);
    return flat * inverseSqrt(max(dot(flat, flat), 1e-20));
}

// Lines a little nearer than the surface they lie on.
@vertex
fn vertex_line(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {
    var clip = g.view_projection * vec4<f32>(position, 1.0);
    clip.z -= 2e-4 * clip.w;
    return clip;
}

@fragment
fn fragment_line() -> @location(0) vec4<f32> {
    return vec4<f32>(0.02, 0.03, 0.05, 0.55);
}

// ---------------------------------------------------------------- noise

fn mixed(h0: u32) -> u32 {
    var h = h0;
    h = (h ^ (h >> 16u)) * 0x7feb352du;
    h = (h ^ (h >> 15u)) * 0x846ca68bu;
    return h ^ (h >> 16u);
}

fn hash(seed: u32, x: i32, y: i32, z: i32) -> u32 {
    let a = mixed(seed ^ (u32(x) * 0x9e3779b9u));
    let b = mixed(a ^ (u32(y) * 0x85ebca6bu));
    return mixed(b ^ (u32(z) * 0xc2b2ae35u));
}

fn unit(seed: u32, x: i32, y: i32, z: i32) -> f32 {
    return f32(hash(seed, x, y, z) >> 8u) / 16777216.0;
}

fn corner(seed: u32, cell: vec3<i32>, f: vec3<f32>, o: vec3<i32>) -> vec4<f32> {
    let c = cell + o;
    let h = hash(seed, c.x, c.y, c.z);
    let grad = vec3<f32>(f32(h & 1023u), f32((h >> 10u) & 1023u), f32((h >> 20u) & 1023u)) * (2.0 / 1023.0) - 1.0;
    return vec4<f32>(grad, dot(grad, f - vec3<f32>(o)));
}

// A step of interpolation of gradient (xyz) and value (w) along one axis.
fn joined(a: vec4<f32>, b: vec4<f32>, s: f32, ds: vec3<f32>) -> vec4<f32> {
    var r = a + (b - a) * s;
    r = vec4<f32>(r.xyz + ds * (b.w - a.w), r.w);
    return r;
}

// Gradient noise with features as wide as 1: gradient in xyz, value (about -1 to 1) in w.
fn noise(seed: u32, p: vec3<f32>) -> vec4<f32> {
    let low = floor(p);
    let cell = vec3<i32>(low);
    let f = p - low;
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let ds = f * f * (f * (f - 2.0) + 1.0) * 30.0;
    let dx = vec3<f32>(ds.x, 0.0, 0.0);
    let dy = vec3<f32>(0.0, ds.y, 0.0);
    let x00 = joined(corner(seed, cell, f, vec3<i32>(0, 0, 0)), corner(seed, cell, f, vec3<i32>(1, 0, 0)), s.x, dx);
    let x10 = joined(corner(seed, cell, f, vec3<i32>(0, 1, 0)), corner(seed, cell, f, vec3<i32>(1, 1, 0)), s.x, dx);
    let x01 = joined(corner(seed, cell, f, vec3<i32>(0, 0, 1)), corner(seed, cell, f, vec3<i32>(1, 0, 1)), s.x, dx);
    let x11 = joined(corner(seed, cell, f, vec3<i32>(0, 1, 1)), corner(seed, cell, f, vec3<i32>(1, 1, 1)), s.x, dx);
    let y0 = joined(x00, x10, s.y, dy);
    let y1 = joined(x01, x11, s.y, dy);
    return joined(y0, y1, s.z, vec3<f32>(0.0, 0.0, ds.z)) * 1.25;
}

// How much of a figure of a size is left when averaged over a footprint.
fn visible(size: f32, footprint: f32) -> f32 {
    return 1.0 - smoothstep(0.4, 1.2, footprint / size);
}

// ---------------------------------------------------------------- wood

struct Look {
    color: vec3<f32>,
    roughness: f32,
    slope: vec3<f32>,
};

// Ring coordinate, and for rings that follow no coordinate their number, place in the ring and width.
fn field_at(across: vec2<f32>) -> vec4<f32> {
    let n = i32(wood.square.w);
    let t = (across - wood.square.xy) / wood.square.z * wood.square.w - 0.5;
    let low = floor(t);
    let f = t - low;
    let c = vec2<i32>(low);
    let last = vec2<i32>(n - 1);
    let zero = vec2<i32>(0);
    let a = textureLoad(ring_field, clamp(c, zero, last), 0);
    let b = textureLoad(ring_field, clamp(c + vec2<i32>(1, 0), zero, last), 0);
    let d = textureLoad(ring_field, clamp(c + vec2<i32>(0, 1), zero, last), 0);
    let e = textureLoad(ring_field, clamp(c + vec2<i32>(1, 1), zero, last), 0);
    let rho = mix(mix(a.x, b.x, f.x), mix(d.x, e.x, f.x), f.y);
    let nearest = textureLoad(ring_field, clamp(vec2<i32>(floor(t + 0.5)), zero, last), 0);
    return vec4<f32>(rho, nearest.yzw);
}

struct Year {
    number: f32,
    fraction: f32,
    width: f32,
    strength: f32,
};

// Years by ring coordinate: texels of 1/1638.4, each with the ring in its middle.
fn year_at(field: vec4<f32>) -> Year {
    var year: Year;
    if (wood.bark.w > 0.5) {
        year.number = field.y;
        year.fraction = field.z;
        year.width = field.w;
        year.strength = unit(wood.seed.x ^ 0x59454152u, i32(field.y), 0, 0);
        return year;
    }
    let last = i32(textureDimensions(ring_years).x) - 1;
    var at = clamp(i32(field.x * 1638.4), 0, last);
    var ring = textureLoad(ring_years, vec2<i32>(at, 0), 0);
    if (field.x > ring.z && at < last) {
        ring = textureLoad(ring_years, vec2<i32>(at + 1, 0), 0);
    } else if (field.x < ring.y && at > 0) {
        ring = textureLoad(ring_years, vec2<i32>(at - 1, 0), 0);
    }
    year.width = max(ring.z - ring.y, 1e-6);
    year.number = ring.x;
    year.fraction = clamp((field.x - ring.y) / year.width, 0.0, 1.0);
    year.strength = ring.w;
    return year;
}

fn late_rise(f: f32, start: f32) -> f32 {
    return max((f - floor(f) - start) / (1.0 - start), 0.0);
}

fn late_integral(f: f32, start: f32) -> f32 {
    let x = late_rise(f, start);
    let one = (1.0 - start) / 3.0;
    return floor(f) * one + one * x * x * x;
}

fn vessel_at(place: vec3<f32>, first: f32, footprint: f32) -> f32 {
    let diameter = wood.vessels.x;
    if (diameter <= 0.0) { return 0.0; }
    let seen = visible(diameter * 1.6, footprint);
    var density = 0.5;
    if (wood.rings.w > 0.5) { density = 0.06 + 0.94 * first; }
    let average = 0.22 * density;
    if (seen <= 0.0) { return average; }
    let width = diameter * 1.5;
    let p = place.xy / width;
    let cell = vec2<i32>(floor(p));
    let seed = wood.seed.x ^ 0x56u;
    let z = place.z / (diameter * 130.0) + unit(seed, cell.x, cell.y, -1);
    let k = floor(z);
    let h = hash(seed, cell.x, cell.y, i32(k));
    if (f32(h & 255u) / 256.0 > density) { return average * (1.0 - seen); }
    let radius = 0.24 + 0.10 * f32((h >> 8u) & 255u) / 256.0;
    let centre = vec2<f32>(radius) + (1.0 - 2.0 * radius) * vec2<f32>(f32((h >> 16u) & 255u), f32(h >> 24u)) / 256.0;
    let off = length(p - vec2<f32>(cell) - centre);
    let soft = max(0.5 * footprint / width, 0.05);
    let taper = smoothstep(0.0, 0.08, min(z - k, 1.0 - (z - k)));
    return mix(average, 1.0 - smoothstep(radius - soft, radius + soft, off), seen) * taper;
}

fn ray_of(number: i32, share: f32, radius: f32, turn: f32, along: f32, footprint: f32) -> f32 {
    let wide = max(0.12e-3, footprint);
    let x = fract(turn) * f32(number);
    let sector = i32(floor(x)) % number;
    let seed = wood.seed.x ^ 0x59u ^ (u32(number) << 8u);
    let z = along / wood.vessels.z + unit(seed, sector, -1, 0);
    let level = i32(floor(z));
    let out = radius / 14e-3 + unit(seed, sector, level, -2);
    let h = hash(seed, sector, level, i32(floor(out)));
    if (f32(h & 1023u) / 1024.0 > 0.75 * clamp(share, 0.0, 1.0)) { return 0.0; }
    let off = abs(fract(x) - 0.2 - 0.6 * f32((h >> 10u) & 1023u) / 1024.0) * 6.2831853 * radius / f32(number);
    let fz = fract(z);
    let fr = fract(out);
    let lens = 4.0 * fz * (1.0 - fz);
    let ends = smoothstep(0.0, 0.15, min(fr, 1.0 - fr));
    let thick = wide * (0.4 + 0.6 * lens);
    let body = (1.0 - smoothstep(0.3 * thick, thick, off)) * ends * smoothstep(0.0, 0.3, lens);
    return body * (0.35 + 0.65 * f32((h >> 20u) & 1023u) / 1024.0) * 0.12e-3 / wide;
}

fn ray_at(across: vec2<f32>, rho: f32, along: f32, footprint: f32) -> f32 {
    let radius = length(across);
    if (wood.vessels.y <= 0.0 || rho > wood.edges.w || radius < 1e-6) { return 0.0; }
    let seen = visible(min(0.55e-3, wood.vessels.z), footprint);
    if (seen <= 0.0) { return 0.046; }
    let wanted = 6.2831853 * radius / 1.1e-3;
    let sectors = max(4.0, exp2(floor(log2(max(wanted, 1.0)))));
    let turn = atan2(across.y, across.x) / 6.2831853;
    let a = ray_of(i32(sectors), 2.0 - wanted / sectors, radius, turn, along, footprint);
    let b = ray_of(i32(sectors) * 2, wanted / sectors - 1.0, radius, turn, along, footprint);
    return mix(0.046, max(a, b), seen);
}

struct Streaks { shade: f32, slope: vec3<f32> };

fn streaks_at(place: vec3<f32>, footprint: f32) -> Streaks {
    var widths = array<f32, 3>(5.0e-3, 1.3e-3, 0.09e-3);
    var shares = array<f32, 3>(0.09, 0.10, 0.20);
    var reliefs = array<f32, 3>(120e-6, 60e-6, 18e-6);
    var out: Streaks;
    out.shade = 0.0;
    out.slope = vec3<f32>(0.0);
    for (var i = 0; i < 3; i++) {
        let seen = visible(widths[i], footprint);
        if (seen <= 0.0) { break; }
        let scale = vec3<f32>(1.0, 1.0, 1.0 / 40.0) / widths[i];
        let n = noise(wood.seed.x ^ 0x53u ^ (u32(i) << 8u), place * scale);
        let squash = select(0.5, 0.35, n.w > 0.0);
        out.shade += n.w * (1.0 - squash * n.w) * shares[i] * seen;
        out.slope += n.xyz * scale * (reliefs[i] * seen);
    }
    return out;
}

// A smooth number from -1 to 1 along the grain for an item of the section.
fn along_at(seed: u32, z0: f32, i: i32, j: i32) -> f32 {
    let z = z0 + fract(0.61803399 * f32(i) + 0.75487767 * f32(j));
    let level = floor(z);
    let f = z - level;
    let a = unit(seed, i, j, i32(level));
    let b = unit(seed, i, j, i32(level) + 1);
    return mix(a, b, f * f * (3.0 - 2.0 * f)) * 2.0 - 1.0;
}

fn boundary_at(seed: u32, z: f32, k: i32, row: i32) -> f32 {
    return f32(k) + 0.47 * along_at(seed, z, k, row);
}

// The interval of a row that holds t, by its number, and its ends.
fn interval_at(seed: u32, z: f32, t: f32, row: i32) -> vec3<f32> {
    let cell = i32(floor(t));
    let low = boundary_at(seed, z, cell, row);
    let high = boundary_at(seed, z, cell + 1, row);
    if (t < low) { return vec3<f32>(f32(cell - 1), boundary_at(seed, z, cell - 1, row), low); }
    if (t >= high) { return vec3<f32>(f32(cell + 1), high, boundary_at(seed, z, cell + 2, row)); }
    return vec3<f32>(f32(cell), low, high);
}

// Height and slope of a roof over an interval, whose ridge lies aside by a number from -1 to 1.
fn roof_at(interval: vec3<f32>, t: f32, aside: f32) -> vec2<f32> {
    let ridge = 0.5 + 0.42 * aside;
    let up = 2.0 * (1.0 - ridge) * (t - interval.y);
    let down = 2.0 * ridge * (interval.z - t);
    if (up < down) { return vec2<f32>(up, 2.0 * (1.0 - ridge)); }
    return vec2<f32>(down, -2.0 * ridge);
}

struct Bundles { shade: f32, gap: f32, tone: f32, slope: vec2<f32> };

// Bundles of fibres: long facets with sharp edges, of three sizes.
fn bundles_at(place: vec3<f32>, facing: vec2<f32>, footprint: f32) -> Bundles {
    var widths = array<f32, 3>(1.1e-3, 0.42e-3, 0.15e-3);
    var stretches = array<f32, 3>(64.0, 70.0, 100.0);
    var shares = array<f32, 3>(0.17, 0.25, 0.21);
    var tilts = array<f32, 3>(0.26, 0.30, 0.24);
    var tones = array<f32, 3>(0.75, 0.65, 0.0);
    let turn = mat2x2<f32>(0.8253356, 0.5646425, -0.5646425, 0.8253356);
    let flat = turn * place.xy;
    // What lies in a gap would be a dark patch; where the normal is not known there is none.
    var crossing = 1.0;
    if (dot(facing, facing) > 1e-6) { crossing = smoothstep(0.3, 0.6, abs((turn * normalize(facing)).y)); }
    var out: Bundles;
    var slope = vec2<f32>(0.0);
    for (var n = 0; n < 3; n++) {
        // A thick stem tears into wider slivers.
        let coarse = select(1.0, clamp(wood.edges.x / 0.04, 1.0, 8.0), n == 0 && wood.edges.y > 0.0);
        let width = widths[n] * coarse;
        let seen = visible(1.25 * width, footprint);
        if (seen <= 0.0) { break; }
        let seed = wood.seed.x ^ 0xb0u ^ (u32(n) << 8u);
        let z = place.z / (width * stretches[n]);
        let at = flat / width;
        let line = interval_at(seed, z, at.y, -0x40000000);
        let row = i32(line.x);
        let column = interval_at(seed ^ 0x10000u, z, at.x, row);
        let number = i32(column.x);
        let is_low = at.x - column.y < column.z - at.x;
        let off = min(at.x - column.y, column.z - at.x);
        let soft = 0.5 * footprint / width;
        let own = along_at(seed ^ 0x20000u, z, number, row);
        var tone = own;
        if (off < soft) {
            let other = along_at(seed ^ 0x20000u, z, number + select(1, -1, is_low), row);
            tone = mix(own, other, 0.5 * (1.0 - off / soft));
        }
        out.shade += tone * shares[n] * seen;
        out.tone += tone * tones[n] * seen;
        let over_x = roof_at(column, at.x, own);
        let over_y = roof_at(line, at.y, own);
        slope += vec2<f32>(over_x.y * over_y.x, over_x.x * over_y.y) * (4.0 * tilts[n] * visible(0.5 * width, footprint));
        let wide = max(0.05, soft);
        if (n < 2 && off < wide) {
            let open = along_at(seed ^ 0x20000u, z, number + select(1, 0, is_low), row ^ 0x55555);
            let gape = smoothstep(0.2, 1.0, open) * crossing * 0.5 * sqrt(0.05 / wide);
            out.gap = max(out.gap, (1.0 - off / wide) * gape * seen);
        }
    }
    out.slope = slope * turn;
    return out;
}

fn tissue(color: vec3<f32>, tissue_color: vec3<f32>, speck: f32, shade: f32, end: f32, inside: f32) -> vec3<f32> {
    return mix(color, tissue_color * ((1.0 + speck + 1.5 * shade) * (1.0 - 0.15 * end)), inside);
}

// The tint of the wood: strips between cream and pink, streaks that are soaked, and moist sapwood beside the bark.
fn tint_at(place: vec3<f32>, rho: f32, tone: f32) -> vec3<f32> {
    let strip = noise(wood.seed.x ^ 0x71u, place / vec3<f32>(6.5e-3, 6.5e-3, 169e-3)).w;
    let warmth = clamp(1.3 * strip + 0.15 * tone, -1.0, 1.0);
    var tint = mix(vec3<f32>(0.965, 1.01, 1.10), vec3<f32>(1.03, 0.99, 0.90), 0.5 + 0.5 * warmth);
    let soaked = noise(wood.seed.x ^ 0x171u, place / vec3<f32>(2.6e-3, 2.6e-3, 109e-3)).w;
    tint *= mix(vec3<f32>(1.0), vec3<f32>(0.93, 0.86, 0.74), smoothstep(0.30, 0.58, soaked + 0.12 * tone));
    return tint * mix(vec3<f32>(1.0), vec3<f32>(0.97, 0.99, 0.86), smoothstep(wood.edges.w - 0.16, wood.edges.w, rho));
}

fn wood_at(across: vec2<f32>, along: f32, end0: f32, facing: vec2<f32>, footprint: f32) -> Look {
    let end = clamp(end0, 0.0, 1.0);
    let place = vec3<f32>(across, along);
    let radius = wood.edges.x;
    let field = field_at(across);
    let rho = field.x;
    let year = year_at(field);
    let ring_width = year.width * radius;
    let half = max(0.6 * footprint / ring_width, 0.02);
    let start = 1.0 - clamp(wood.rings.z, 0.02, 1.0);
    let mean = (late_integral(year.fraction + half, start) - late_integral(year.fraction - half, start)) / (2.0 * half);
    let a = late_rise(year.fraction + half, start);
    let b = late_rise(year.fraction - half, start);
    let strength = wood.rings.y * (0.55 + 0.45 * year.strength);
    let late = mean * strength;
    let late_slope = (a * a - b * b) / (2.0 * half) * strength / ring_width;
    let first = select(1.0, 1.0 - smoothstep(0.12, 0.34, year.fraction), wood.rings.w > 0.5);
    var streaks = streaks_at(place, footprint);
    let bundles = bundles_at(place, facing, footprint);
    // A saw cuts all fibres at one height.
    streaks.shade = (streaks.shade + bundles.shade) * (1.0 - 0.5 * end);
    streaks.slope = (streaks.slope + vec3<f32>(bundles.slope, 0.0)) * (1.0 - 0.5 * end);
    let vessel = vessel_at(place, first, footprint);
    let ray = wood.vessels.y * ray_at(across, rho, along, footprint);

    var heart = 0.0;
    if (wood.edges.z > 0.0) {
        let wander = noise(wood.seed.x ^ 0x48u, place / vec3<f32>(0.4, 0.4, 10.0) / radius).w;
        let edge = wood.edges.z + 0.07 * wander;
        heart = 1.0 - smoothstep(edge - 0.075, edge + 0.055, rho);
    }
    var color = mix(wood.sapwood.rgb, wood.heartwood.rgb, heart);
    color *= tint_at(place, rho, bundles.tone);
    color *= max(mix(vec3<f32>(1.0), wood.latewood.rgb / max(wood.sapwood.rgb, vec3<f32>(1e-3)), mix(1.8, 1.35, end) * late), vec3<f32>(0.1));
    color *= 1.0 - 0.30 * end * (1.0 - 0.25 * late);
    color *= vec3<f32>(1.0) - vec3<f32>(0.50, 0.58, 0.66) * vessel;
    color *= mix(vec3<f32>(0.80, 0.74, 0.68), vec3<f32>(1.22, 1.24, 1.26), end) * ray + (1.0 - ray);
    color *= max(vec3<f32>(1.0) + vec3<f32>(1.0, 1.18, 1.45) * streaks.shade, vec3<f32>(0.1));

    color *= vec3<f32>(1.0) - vec3<f32>(0.62, 0.70, 0.78) * (bundles.gap * (1.0 - 0.65 * end));

    // Pith and barks over the wood near and beyond their edges.
    let soft = max(footprint / radius, 0.004);
    let thick = clamp(wood.rings.x - wood.edges.w, 0.0, 0.1);
    if (rho > wood.edges.w - soft - 0.01 - thick || rho <= wood.edges.y * 1.15 + soft + 0.01) {
        let width = max(1.1e-3, 0.02 * radius);
        let ragged = noise(wood.seed.x ^ 0x4bu, place / width * vec3<f32>(1.0, 1.0, 1.0 / 7.3)).w;
        let speck = ragged * visible(width, footprint);
        let in_pith = 1.0 - smoothstep(wood.edges.y * 0.7 - soft, wood.edges.y * 1.15 + soft, rho + 0.008 * ragged);
        color = tissue(color, wood.pith.rgb, 0.22 * speck, streaks.shade, end, in_pith * step(1e-6, wood.edges.y));
        let u1 = noise(wood.seed.x ^ 0x14bu, place / (0.5 * radius) * vec3<f32>(1.0, 1.0, 0.25)).w;
        let u2 = noise(wood.seed.x ^ 0x24bu, place / (0.13 * radius) * vec3<f32>(1.0, 1.0, 0.25)).w;
        let uneven = thick * (0.5 * u1 + 0.32 * u2);
        let wavy = rho + 0.008 * ragged + uneven + 0.006 * bundles.tone;
        // The two edges wander apart.
        let outer = rho + 0.008 * ragged - uneven;
        // Bark comes off at the cambium: a face that looks outwards there is wood, with strings of inner bark.
        let outwards = dot(facing, across) / max(length(facing) * length(across), 1e-9);
        let peeled = smoothstep(0.15, 0.5, outwards) * (1.0 - end) * (1.0 - smoothstep(wood.edges.w + 0.006, wood.edges.w + 0.016, rho));
        // More of those are left farther from the cambium.
        let inner = max(wood.rings.x - wood.edges.w, 1e-6);
        let patched = 2.4 * width;
        let patch_at = noise(wood.seed.x ^ 0xba57u, place / patched * vec3<f32>(1.0, 1.0, 1.0 / 16.0)).w;
        let stays = mix(0.42, -0.06, clamp((rho - wood.edges.w) / inner, 0.0, 1.0));
        let strings = 0.85 * smoothstep(stays - 0.1, stays + 0.1, patch_at + 0.5 * ragged + 0.3 * bundles.tone);
        let in_phloem = smoothstep(wood.edges.w - soft - 0.012, wood.edges.w + soft + 0.012, wavy) * (1.0 - peeled * (1.0 - strings));
        let depth = (1.0 - 0.2 * peeled) * (wavy - wood.edges.w) / inner;
        let living = 1.0 - smoothstep(0.0, 1.1, depth + 0.45 * bundles.tone);
        let pale = mix(wood.phloem.rgb, wood.sapwood.rgb * vec3<f32>(0.92, 0.90, 0.80), 0.45);
        let bast = mix(wood.phloem.rgb * vec3<f32>(0.70, 0.61, 0.51) * (1.0 + 0.38 * bundles.tone), pale, living);
        color = tissue(color, bast, 0.20 * speck, streaks.shade, end, in_phloem);
        let in_cork = smoothstep(wood.rings.x - soft, wood.rings.x + soft, outer) * (1.0 - peeled);
        color = tissue(color, wood.cork.rgb, 0.42 * speck, streaks.shade, end, in_cork);
    }
    var look: Look;
    look.color = clamp(color, vec3<f32>(0.004), vec3<f32>(1.0));
    look.roughness = clamp(0.78 - 0.10 * late + 0.12 * end + 0.3 * abs(streaks.shade), 0.3, 1.0);
    let outward = across / max(length(across), 1e-6);
    look.slope = streaks.slope + vec3<f32>(outward * (40e-6 * late_slope), 0.0);
    return look;
}

// A smooth number from -1 to 1 along a line.
fn value_at(seed: u32, x: f32) -> f32 {
    let level = floor(x);
    let f = x - level;
    let a = unit(seed, i32(level), 0, 0);
    let b = unit(seed, i32(level) + 1, 0, 0);
    return mix(a, b, f * f * (3.0 - 2.0 * f)) * 2.0 - 1.0;
}

// The arcs that a saw left, and its scratches: the arc, and the height of the relief (m).
fn saw_relief(seed: u32, turn: vec2<f32>, p: vec2<f32>, arcs: f32, scratches: f32) -> vec2<f32> {
    let away = p - turn * 0.19;
    let out = length(away) - 0.19;
    let around = turn.x * away.y - turn.y * away.x;
    let waver = 0.9 * value_at(seed ^ 1u, out / 6e-3);
    let strength = 0.55 + 0.45 * value_at(seed ^ 2u, out / 3.22e-3);
    let arc = sin(6.2831853 * (out / 1.4e-3 + waver)) * strength;
    var scratch = 0.0;
    if (scratches > 0.0) { scratch = noise(seed ^ 3u, vec3<f32>(out / 0.3e-3, around / 11e-3, 0.5)).w; }
    return vec2<f32>(arc, 55e-6 * arcs * arc + 18e-6 * scratches * scratch);
}

// Brightness, and slope of the relief, of a sawn end.
fn saw_at(across: vec2<f32>, footprint: f32) -> vec3<f32> {
    let seed = wood.seed.x ^ 0x5au;
    let angle = 6.2831853 * unit(seed, 0, 0, 0);
    let turn = vec2<f32>(cos(angle), sin(angle));
    let arcs = visible(1.4e-3, footprint);
    let scratches = visible(0.3e-3, footprint);
    let here = saw_relief(seed, turn, across, arcs, scratches);
    let x = saw_relief(seed, turn, across + vec2<f32>(8e-6, 0.0), arcs, scratches);
    let y = saw_relief(seed, turn, across + vec2<f32>(0.0, 8e-6), arcs, scratches);
    return vec3<f32>(1.0 + 0.07 * arcs * here.x, (vec2<f32>(x.y, y.y) - here.y) / 8e-6);
}

fn bark_at(place: vec3<f32>, footprint: f32) -> Look {
    let width = wood.bark.x;
    let depth = wood.bark.y;
    let seed = wood.seed.y ^ 0xba7cu;
    var sizes = array<f32, 3>(1.0, 0.47, 0.19);
    var stretches = array<f32, 3>(8.0, 8.0, 9.0);
    var shares = array<f32, 3>(1.0, 0.50, 0.22);
    var depths = array<f32, 3>(0.49, 0.335, 0.31);
    // Ridges are of several widths: the bark is shifted about the stem before furrows are cut.
    let out = vec3<f32>(place.xy / max(length(place.xy), 1e-6), 0.0);
    let around = vec3<f32>(-out.y, out.x, 0.0);
    let uneven_scale = vec3<f32>(1.0, 1.0, 1.0 / 6.0) / (3.4 * width);
    let uneven = noise(seed ^ 6u, place * uneven_scale);
    let ridged = place + around * (0.8 * width * uneven.w);
    let ridged_rise = uneven.xyz * uneven_scale * (0.8 * width);
    // Shallow furrows are narrow.
    let openness = clamp(depth / width / 0.15, 0.35, 1.0);
    var edges = array<f32, 3>(0.34 * openness, 0.22 * openness, 0.20 * openness);
    var ridge = 1.0;
    var height = 0.0;
    var slope = vec3<f32>(0.0);
    for (var i = 0; i < 3; i++) {
        let size = sizes[i] * width;
        // The slope of a furrow's side has to be seen, which is narrower than the ridge.
        let seen = visible(min(1.8 * edges[i], 1.0) * size * min(stretches[i], 1.0), footprint);
        var open = 1.0 - depths[i] * openness;
        if (seen > 0.0) {
            let own = seed ^ (u32(i + 1) << 16u);
            let shift = noise(own ^ 1u, ridged * vec3<f32>(0.9, 0.9, 0.35) / size).w;
            let moved = ridged + vec3<f32>(shift, -shift, 0.0) * (0.5 * size);
            let scale = vec3<f32>(1.0, 1.0, 1.0 / stretches[i]) / size;
            let n = noise(own, moved * scale);
            let opening = noise(own ^ 2u, ridged * vec3<f32>(0.7, 0.7, 0.3) / size).w;
            let widened = 1.0 + 1.1 * opening;
            let edge = edges[i] * max(widened, 0.12);
            let x = min(abs(n.w) / edge, 1.0);
            // Furrows that narrow get shallower too, and end; the widest part all ridges.
            var share = 1.0;
            if (i > 0) {
                share = smoothstep(0.12, 0.75, widened);
            }
            open = mix(open, 1.0 - share * (1.0 - x * x * (3.0 - 2.0 * x)), seen);
            if (x < 1.0) {
                let rise = n.xyz * scale * sign(n.w) / edge;
                slope += (rise + ridged_rise * dot(rise, around)) * (share * 6.0 * x * (1.0 - x) * depth * shares[i] * seen);
            }
        }
        height -= depth * shares[i] * (1.0 - open);
        ridge *= 1.0 - shares[i] * (1.0 - open);
    }
    // Bark is smooth in some places and rough in others.
    let patch_scale = vec3<f32>(1.0, 1.0, 1.0 / 2.2) / (7.0 * width);
    let smooth_patch = noise(seed ^ 7u, place * patch_scale);
    let rough = max(1.0 + 1.8 * smooth_patch.w, 0.2);
    slope *= rough;
    if (rough > 0.2) {
        slope += smooth_patch.xyz * patch_scale * (1.8 * height);
    }
    ridge = max(1.0 - rough * (1.0 - ridge), 0.0);
    var flake_sizes = array<f32, 4>(1.7, 0.5, 0.16, 0.055);
    var flake_shares = array<f32, 4>(0.09, 0.26, 0.36, 0.34);
    var shade = 0.0;
    for (var i = 0; i < 4; i++) {
        let size = flake_sizes[i] * width;
        let seen = visible(size, footprint);
        if (seen <= 0.0) { break; }
        let scale = vec3<f32>(1.0, 1.0, 0.6) / size;
        let n = noise(seed ^ (u32(i + 2) << 8u), place * scale);
        shade += n.w * (1.0 + 0.6 * abs(n.w)) * flake_shares[i] * seen;
        // Slopes of one pixel would glitter.
        slope += n.xyz * scale * (0.16 * min(size, depth * 4.0) * visible(0.5 * size, footprint));
    }
    let patchy = noise(seed ^ 3u, place * vec3<f32>(1.0, 1.0, 0.7) / (5.0 * width)).w;
    let lichen = 0.62 * smoothstep(0.36, 0.47, patchy + 1.25 * shade);
    var weathered = mix(wood.ridge.rgb, vec3<f32>(0.27, 0.275, 0.225), max(lichen, clamp(0.34 + 0.12 * patchy + 0.45 * shade, 0.0, 0.68)));
    // Algae grow on the side that stays damp.
    let damp = 6.2831853 * unit(seed, 5, 0, 0);
    let side = smoothstep(-0.35, 1.0, dot(place.xy, vec2<f32>(cos(damp), sin(damp))) / max(length(place.xy), 1e-6));
    let alga = noise(seed ^ 5u, place * vec3<f32>(1.0, 1.0, 0.5) / (9.0 * width)).w;
    weathered = mix(weathered, vec3<f32>(0.128, 0.142, 0.066), 0.40 * side * smoothstep(-0.55, 0.45, alga + 0.7 * shade));
    var look: Look;
    var color = mix(wood.furrow.rgb, weathered, 0.3 + 0.7 * ridge) * max(1.0 + 1.3 * shade, 0.15);
    if (wood.vessels.w > 0.0) {
        let v = noise(seed ^ 4u, place * vec3<f32>(1.0, 1.0, 6.0) / (0.5 * width)).w;
        let spot = smoothstep(0.45, 0.62, v) * wood.vessels.w * visible(0.1 * width, footprint);
        color = mix(color, vec3<f32>(0.30, 0.22, 0.15), spot);
    }
    look.color = clamp(color, vec3<f32>(0.004), vec3<f32>(1.0));
    look.roughness = 0.95;
    look.slope = slope;
    return look;
}

// ---------------------------------------------------------------- light

fn shadow_at(position: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>) -> f32 {
    let lit = g.light_projection * vec4<f32>(position + normal * (1.5 * g.flags.y), 1.0);
    let uv = vec2<f32>(0.5, -0.5) * lit.xy + 0.5;
    let depth = lit.z;
    // A turn for each pixel of a 4 x 4 tile hides the pattern of the taps.
    let tile = vec2<u32>(pixel) % vec2<u32>(4u);
    let turn = f32((tile.x * 5u + tile.y * 11u) % 16u) * 0.3927;
    let c = cos(turn);
    let s = sin(turn);
    var sum = 0.0;
    for (var i = 0; i < 12; i++) {
        let r = sqrt((f32(i) + 0.5) / 12.0);
        let angle = f32(i) * 2.39996;
        let d = vec2<f32>(cos(angle), sin(angle)) * r;
        let tap = uv + vec2<f32>(d.x * c - d.y * s, d.x * s + d.y * c) * g.key_direction.w;
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, tap, depth);
    }
    // The near and far planes hold the whole scene; beside the map there is light.
    let inside = all(uv >= vec2<f32>(0.0)) && all(uv <= vec2<f32>(1.0));
    return select(1.0, sum / 12.0, inside);
}

// How much of the surroundings a point sees past what is near it: the mean over pixels around of how high they stand over its plane,
// less the farther they are. After M. McGuire, M. Mara and D. Luebke, "Scalable Ambient Obscurance" (High-Performance Graphics 2012),
// with distances instead of a depth buffer and without a blur: the turn of the taps differs within tiles of 4 x 4 pixels.
fn openness(position: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>, footprint: f32) -> f32 {
    let reach = g.flags.z;
    let radius = min(reach / footprint, 96.0);
    if (radius < 2.0) { return 1.0; }
    let limit = radius * footprint;
    let upwards = cross(g.right.xyz, g.forward.xyz);
    let own = dot(position, g.forward.xyz);
    let last = vec2<i32>(textureDimensions(distances)) - 1;
    let tile = vec2<u32>(pixel) % vec2<u32>(4u);
    let turn = f32((tile.x * 7u + tile.y * 13u) % 16u) * 0.3927;
    var sum = 0.0;
    for (var i = 0; i < 14; i++) {
        let r = (f32(i) + 0.5) / 14.0 * radius;
        let angle = f32(i) * 2.39996 + turn;
        let at = vec2<i32>(floor(pixel + vec2<f32>(cos(angle), sin(angle)) * r));
        let bytes = textureLoad(distances, clamp(at, vec2<i32>(0), last), 0).rgb * 255.0;
        let part = dot(bytes, vec3<f32>(1.0 / 256.0, 1.0 / 65536.0, 1.0 / 16777216.0));
        let off = (vec2<f32>(at) + 0.5 - pixel) * footprint;
        let depth = (2.0 * part - 1.0) * g.forward.w - own;
        let v = g.right.xyz * off.x - upwards * off.y + g.forward.xyz * depth;
        let square = dot(v, v);
        let rise = max(dot(v, normal) - 0.02 * limit - footprint, 0.0) * inverseSqrt(square + 1e-4 * limit * limit);
        sum += rise * max(1.0 - square / (limit * limit), 0.0);
    }
    return clamp(1.0 - 2.4 * sum / 14.0, 0.25, 1.0);
}

fn scatter(color: vec3<f32>, roughness: f32, metal: f32, n: vec3<f32>, v: vec3<f32>, l: vec3<f32>) -> vec3<f32> {
    let h = normalize(l + v);
    let nl = max(dot(n, l), 1e-4);
    let nv = max(dot(n, v), 0.05);
    let nh = max(dot(n, h), 0.0);
    let vh = clamp(dot(v, h), 0.0, 1.0);
    let r = roughness * roughness;
    let a = r * r;
    let d = nh * nh * (a - 1.0) + 1.0;
    let masking = nl * sqrt(nv * nv * (1.0 - a) + a) + nv * sqrt(nl * nl * (1.0 - a) + a);
    let f0 = mix(vec3<f32>(0.04), color, metal);
    let fresnel = f0 + (1.0 - f0) * pow(1.0 - vh, 5.0);
    return color * (1.0 - metal) * (1.0 - fresnel) / 3.14159265 + a / (3.14159265 * d * d) * 0.5 / masking * fresnel;
}

// The radiance of the sky and the ground around, averaged over the lobe of a surface of a roughness: the sharper the surface, the
// sharper the horizon in it.
fn surroundings(direction: vec3<f32>, roughness: f32) -> vec3<f32> {
    let edge = mix(0.12, 1.0, roughness);
    let above = smoothstep(-edge, edge, dot(direction, g.up.xyz));
    return mix(vec3<f32>(0.336), vec3<f32>(0.50, 0.53, 0.58), above);
}

// What a surface reflects of even surroundings, as scale and offset of its reflectance at normal incidence: the second factor of the
// split sum, as the fit of B. Karis, "Physically Based Shading on Mobile" (Unreal Engine, 2014), after D. Lazarov, "Getting More
// Physical in Call of Duty: Black Ops II" (SIGGRAPH 2013).
fn reflected_share(roughness: f32, nv: f32) -> vec2<f32> {
    let r = roughness * vec4<f32>(-1.0, -0.0275, -0.572, 0.022) + vec4<f32>(1.0, 0.0425, 1.04, -0.04);
    let a = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    return vec2<f32>(-1.04, 1.04) * a + r.zw;
}

fn tone(v: vec3<f32>) -> vec3<f32> {
    let over = max(v - 0.65, vec3<f32>(0.0)) / 0.35;
    let mapped = select(v, 0.65 + 0.35 * over / (1.0 + over), v > vec3<f32>(0.65));
    let low = mapped * 12.92;
    let high = 1.055 * pow(max(mapped, vec3<f32>(1e-6)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(high, low, mapped <= vec3<f32>(0.0031308));
}

fn hue(t: f32) -> vec3<f32> {
    let p = abs(fract(t + vec3<f32>(0.0, 0.6667, 0.3333)) * 6.0 - 3.0);
    return mix(vec3<f32>(1.0), clamp(p - 1.0, vec3<f32>(0.0), vec3<f32>(1.0)), 0.55) * 0.62;
}

fn zone_color(zone: f32) -> vec3<f32> {
    let z = i32(round(zone));
    if (z == 0) { return vec3<f32>(0.16, 0.06, 0.03); }
    if (z == 1) { return vec3<f32>(0.42, 0.14, 0.06); }
    if (z == 2) { return vec3<f32>(0.75, 0.47, 0.17); }
    if (z == 3) { return vec3<f32>(0.25, 0.42, 0.10); }
    return vec3<f32>(0.11, 0.10, 0.12);
}

// The tissue at a ring coordinate, for what lies in all of them.
fn zone_at(rho: f32) -> f32 {
    if (rho > wood.rings.x) { return 4.0; }
    if (rho > wood.edges.w) { return 3.0; }
    if (rho > wood.edges.z) { return 2.0; }
    return select(1.0, 0.0, rho <= wood.edges.y);
}

@fragment
fn fragment_main(v: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let to_eye = g.eye.xyz - v.position;
    let distance = length(to_eye);
    let view = to_eye / distance;
    let footprint = distance * g.eye.w;
    // The plane of the triangle, and how the grain coordinates rise along it.
    let dp1 = dpdx(v.position);
    let dp2 = dpdy(v.position);
    let dg1 = dpdx(v.grain.xyz);
    let dg2 = dpdy(v.grain.xyz);
    let texel = base_texel(v.uv);
    let relief_place = texture_place(v.uv, surface.relief.xy, surface.relief_map);
    let relief = textureSample(relief_texture, relief_sampler, relief_place).xyz;
    let dt1 = dpdx(relief_place);
    let dt2 = dpdy(relief_place);
    // Seen where the texture is; where it has none, everywhere.
    let opacity = select(1.0, texel.w, surface.kind.w > 0.5) * surface.base.w;
    let sharp = (opacity - surface.opacity.y) / max(fwidth(opacity), 1e-4) + 0.5;
    if (is_cut_away(v.position)) { discard; }
    let plane = cross(dp1, dp2);
    let area = max(length(plane), 1e-20);
    var flat = plane / area;
    if (dot(flat, view) < 0.0) { flat = -flat; }
    let m = plane / area;
    let g1 = cross(dp2, m) / area;
    let g2 = cross(m, dp1) / area;
    let rise_x = g1 * dg1.x + g2 * dg2.x;
    let rise_y = g1 * dg1.y + g2 * dg2.y;
    let rise_z = g1 * dg1.z + g2 * dg2.z;
    var normal = flat;
    if (dot(v.normal, v.normal) > 0.1) {
        normal = normalize(v.normal);
        if (dot(normal, flat) < 0.0) { normal = -normal; }
    }
    let end = sqrt(max(1.0 - dot(rise_z, rise_z), 0.0));
    let on_stem = v.grain.w > 0.5;
    let mode = i32(g.up.w);
    let across = v.grain.xy - wood.middle.xy;
    var look: Look;
    look.color = surface.base.rgb;
    look.roughness = surface.kind.y;
    look.slope = vec3<f32>(0.0);
    var metal = 0.0;
    let is_wood = surface.kind.z > 0.5 && surface.kind.z < 1.5 && on_stem;
    let is_skin = surface.kind.z > 1.5;
    let sawn = is_skin && on_stem && (wood.bark.z > 0.5 || dot(rise_z, rise_z) < 0.19);
    if (mode == 0) {
        if (is_wood || sawn) {
            // The normal in the directions of the grain, from how its coordinates rise in the plane.
            let facing = vec2<f32>(dot(flat, cross(rise_y, rise_z)), dot(flat, cross(rise_z, rise_x)));
            look = wood_at(across, v.grain.z, end, facing, footprint);
            if (is_wood) {
                // Torn wood is paler and matt.
                let light = dot(look.color, vec3<f32>(0.2126, 0.7152, 0.0722));
                // More so where fibres broke across and stand as a brush.
                look.color = mix(look.color, vec3<f32>(light), 0.16 + 0.12 * end) * (1.0 + 0.2 * end);
                look.color = min(look.color, vec3<f32>(1.0));
                look.roughness = max(look.roughness, 0.82);
            } else if (end > 0.9) {
                let saw = saw_at(across, footprint);
                look.color = clamp(look.color * saw.x, vec3<f32>(0.004), vec3<f32>(1.0));
                look.slope += vec3<f32>(saw.yz, 0.0);
            } else {
                // Planed wood is smooth.
                look.slope *= 0.25;
            }
        } else if (is_skin) {
            if (on_stem) {
                look = bark_at(vec3<f32>(across, v.grain.z), footprint);
            } else if (v.grain.w > 0.0) {
                // Along the limb, whose bark is finer: the relief is as much shallower.
                let finer = 0.4 / v.grain.w;
                look = bark_at(v.grain.xyz, footprint * finer);
                look.slope /= finer;
            } else {
                // What has too many points for that: about the vertical, as far out as the stem is thick.
                let out = normal.xz / max(length(normal.xz), 1e-6);
                look = bark_at(vec3<f32>(out * wood.edges.x, v.position.y), footprint);
            }
        } else {
            metal = surface.kind.x;
            if (surface.kind.w > 0.5) { look.color *= texel.rgb; }
            if (surface.relief.w > 0.5) {
                normal = tilted(normal, g1 * dt1.x + g2 * dt2.x, g1 * dt1.y + g2 * dt2.y, relief);
            }
        }
    } else if (mode == 1) {
        var zone = v.zone_piece.x;
        if (zone < -0.5) { zone = zone_at(field_at(across).x); }
        look.color = select(vec3<f32>(0.3), zone_color(zone), on_stem);
        look.roughness = 0.9;
    } else if (mode == 2) {
        look.color = vec3<f32>(0.3);
        if (on_stem && (is_wood || sawn)) {
            let year = year_at(field_at(across));
            look.color = hue(year.number * 0.381966) * (1.0 - 0.55 * smoothstep(0.6, 1.0, year.fraction));
        }
        look.roughness = 0.9;
    } else if (mode == 3) {
        look.color = hue(v.zone_piece.y * 0.381966 + 0.08);
        look.roughness = 0.9;
    } else {
        look.color = vec3<f32>(0.55, 0.55, 0.54);
        look.roughness = 0.85;
    }
    let rise = rise_x * look.slope.x + rise_y * look.slope.y + rise_z * look.slope.z;
    let tangential = rise - normal * dot(normal, rise);
    var n = normalize(normal - tangential);
    let cosine = dot(n, flat);
    if (cosine < 0.1) { n = normalize(n + flat * (0.1 - cosine)); }

    let right_light = shadow_at(v.position, flat, v.clip.xy);
    let key = g.key_direction.xyz;
    let rim = g.rim_direction.xyz;
    let up = g.up.xyz;
    let roughness = clamp(look.roughness, 0.3, 1.0);
    // As in the pictures: what faces away from a light in its plane is in its own shadow.
    var radiance = scatter(look.color, roughness, metal, n, view, key) * vec3<f32>(2.55, 2.45, 2.28)
        * max(dot(n, key), 0.0) * smoothstep(-0.1, 0.15, dot(flat, key)) * right_light;
    radiance += scatter(look.color, roughness, metal, n, view, rim) * vec3<f32>(0.85, 0.92, 1.05)
        * max(dot(n, rim), 0.0) * smoothstep(-0.1, 0.15, dot(flat, rim));
    let sky = mix(vec3<f32>(0.336), vec3<f32>(0.50, 0.53, 0.58), 0.5 + 0.5 * dot(n, up));
    let nv = max(dot(n, view), 0.05);
    let share = reflected_share(roughness, nv);
    let reflected = mix(vec3<f32>(0.04), look.color, metal) * share.x + share.y;
    // Where the key light does not get in, less of the sky does either.
    let open = mix(0.72, 1.0, right_light) * openness(v.position, normal, v.clip.xy, footprint);
    radiance += look.color * (1.0 - metal) * (1.0 - reflected) * sky * open;
    radiance += reflected * surroundings(reflect(-view, n), roughness) * open;
    // The part of a pixel's samples that are drawn; only pipelines for what has holes read it.
    let covered = select(opacity, clamp(sharp, 0.0, 1.0), surface.opacity.x < 1.5);
    return vec4<f32>(tone(radiance), covered);
}

// ---------------------------------------------------------------- background and copy to the window

struct Screen {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
};

@vertex
fn vertex_screen(@builtin(vertex_index) i: u32) -> Screen {
    var out: Screen;
    let p = vec2<f32>(f32((i << 1u) & 2u), f32(i & 2u));
    out.clip = vec4<f32>(p * 2.0 - 1.0, 1.0, 1.0);
    out.uv = vec2<f32>(p.x, 1.0 - p.y);
    return out;
}

@fragment
fn fragment_background(s: Screen) -> @location(0) vec4<f32> {
    let p = s.uv * 2.0 - 1.0;
    let far = min(dot(p, p) * 0.5, 1.0);
    let shade = 1.0 - 0.28 * far * far * (3.0 - 2.0 * far);
    return vec4<f32>(tone(g.background.rgb * shade), 1.0);
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

@fragment
fn fragment_copy(s: Screen) -> @location(0) vec4<f32> {
    return vec4<f32>(textureSampleLevel(picture, picture_sampler, s.uv, 0.0).rgb, 1.0);
}

@fragment
fn fragment_copy_linear(s: Screen) -> @location(0) vec4<f32> {
    let c = textureSampleLevel(picture, picture_sampler, s.uv, 0.0).rgb;
    let low = c / 12.92;
    let high = pow((c + 0.055) / 1.055, vec3<f32>(2.4));
    return vec4<f32>(select(high, low, c <= vec3<f32>(0.04045)), 1.0);
}
