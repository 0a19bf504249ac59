//! Filters of meshopt-compressed attributes, after Appendix B of `EXT_meshopt_compression` and `KHR_meshopt_compression`.

/// A filter that is undone after decompression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

impl Filter {
    pub fn from_name(name: &str) -> Option<Filter> {
        Some(match name {
            "NONE" => Filter::None,
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            "COLOR" => Filter::Color,
            _ => return None,
        })
    }
}

/// Undoes a filter in place, on elements of `stride` bytes.
pub(super) fn undo(filter: Filter, data: &mut [u8], stride: usize) -> Result<(), &'static str> {
    let (fours, _) = data.as_chunks_mut::<4>();
    match (filter, stride) {
        (Filter::None, _) => {}
        (Filter::Octahedral, 4) => {
            for v in fours {
                let [x, y, z, _] = v.map(|b| f32::from(b as i8));
                let unit = octahedral(x, y, z, 127.0);
                for (b, value) in v.iter_mut().zip(unit) {
                    *b = value as i8 as u8;
                }
            }
        }
        (Filter::Color, 4) => {
            for v in fours {
                let signed = |b: u8| i32::from(b as i8);
                let ycocg = [v[0].into(), signed(v[1]), signed(v[2]), v[3].into()];
                *v = color(ycocg, 255.0).map(|c| c as u8);
            }
        }
        (Filter::Octahedral, 8) => map_words(data, |v| {
            let [x, y, z, _] = v.map(|w| f32::from(w as i16));
            let unit = octahedral(x, y, z, 32767.0).map(|c| c as i16 as u16);
            [unit[0], unit[1], unit[2], v[3]]
        }),
        (Filter::Quaternion, 8) => map_words(data, quaternion),
        (Filter::Color, 8) => map_words(data, |v| {
            let signed = |w: u16| i32::from(w as i16);
            let ycocg = [v[0].into(), signed(v[1]), signed(v[2]), v[3].into()];
            color(ycocg, 65535.0).map(|c| c as u16)
        }),
        (Filter::Exponential, _) => {
            for v in fours {
                let code = i32::from_le_bytes(*v);
                // In f64 the power cannot overflow for any of the 256 exponents.
                let value = f64::from(code << 8 >> 8) * f64::from(code >> 24).exp2();
                *v = (value as f32).to_le_bytes();
            }
        }
        _ => return Err("a filter on elements of the wrong stride"),
    }
    Ok(())
}

/// Maps elements of four 16-bit words.
fn map_words(data: &mut [u8], map: impl Fn([u16; 4]) -> [u16; 4]) {
    for v in data.as_chunks_mut::<8>().0 {
        let words = [0, 2, 4, 6].map(|k| u16::from_le_bytes([v[k], v[k + 1]]));
        for (bytes, word) in v.as_chunks_mut::<2>().0.iter_mut().zip(map(words)) {
            *bytes = word.to_le_bytes();
        }
    }
}

/// Decodes a unit vector from the octahedral mapping.
fn octahedral(x: f32, y: f32, one: f32, full: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower hemisphere is folded over the corners of the square.
    let t = z.min(0.0);
    let (x, y) = (x - t.copysign(x), y - t.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|c| (c / length * full).round())
}

/// Decodes a unit quaternion without its largest component.
fn quaternion(v: [u16; 4]) -> [u16; 4] {
    let one = f32::from((v[3] | 3) as i16);
    let [x, y, z] =
        [v[0], v[1], v[2]].map(|c| f32::from(c as i16) / one * std::f32::consts::FRAC_1_SQRT_2);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let largest = usize::from(v[3] & 3);
    let mut out = [0; 4];
    for (k, c) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + k) % 4] = (c * 32767.0).round() as i16 as u16;
    }
    out
}

/// Decodes a colour from YCoCg.
fn color([y, co, cg, alpha]: [i32; 4], full: f32) -> [f32; 4] {
    // The highest bit of alpha shows the number of bits.
    let span = (1_i32 << (32 - alpha.leading_zeros())) - 1;
    let a = alpha & (span >> 1);
    let scale = full / (span as f32).max(1.0);
    [y + co - cg, y + cg, y - co - cg, a << 1 | a & 1].map(|c| (c as f32 * scale).round())
}
