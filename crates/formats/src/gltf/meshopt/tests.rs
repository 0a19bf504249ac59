//! Streams made by the reference encoder (meshoptimizer 1.0, JavaScript), decoded to what went in.

use super::*;

fn unhex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text
        .chars()
        .filter_map(|c| c.to_digit(16))
        .map(|d| d as u8)
        .collect();
    digits.chunks_exact(2).map(|d| d[0] << 4 | d[1]).collect()
}

fn view(mode: &str, filter: &str, count: usize, stride: usize) -> Compressed {
    Compressed {
        buffer: 0,
        byte_offset: 0,
        byte_length: 0,
        byte_stride: stride,
        count,
        mode: mode.to_owned(),
        filter: Some(filter.to_owned()),
    }
}

const SMOOTH_0: &str = "\
    a0ffffffff004c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e \
    524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e5240 \
    44484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e52404448 \
    4c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c50 \
    5442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442 \
    464a4e524044484c505442464a4e524044484c505442464a4e524044484c50555555550002000800200080020008 \
    00200080020020002002000800200080020008002000800200080020008002002000800200080020008002000800 \
    20008002002000aaaaaaaa0999999999999999999999999999999999999999999999999999999999999999999999 \
    99999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999 \
    99999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999 \
    994110040110000000004000000001000000000400000000100000000000000000afaa555500ffff808040404040 \
    2020202020202020101010101010101010101010101010f888888888888888108888888888888888844444444444 \
    4444444444444444444444444444444444444444444444444444eaaaaaaa04aaaaaaaaaaaaaaaaaaaaaaaaaaaaaa \
    aaaaaaaaaaaaaaaaaaaaaaaaaa11000100380080007e80000000800000003f5442464a4e524044484c505442464a \
    4e524044484c505442464a4e524044484c505442464a4e524044484c500000000015800200080020008002000800 \
    2a9999999999999999999999999999999999999999999900000110000000003f00ffffffffffffffffffffffffff \
    ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff00000000158888888888888888888888 \
    00000000000000000000000000000000000000000000000000000000000000000000";
const SMOOTH_1: &str = "\
    a19b1a004c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e5240 \
    44484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e52404448 \
    4c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c50 \
    5442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442 \
    464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a4e524044484c505442464a \
    4e524044484c505442464a4e524044484c505442464a4e524044484c50aaaaaaaa09999999999999999999999999 \
    99999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999 \
    99999999999999999999999999999999999999999999999999999999999999999999999999999999999999999999 \
    9999999999999999999999999999999999999999999999acaa5555f8ff8080404040402020202020202020101010 \
    101010101010101010101010f8888888888888881088888888888888888444444444444444444444444444444444 \
    444444444444444444444444444444eaaaaaaa04aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa \
    aaaa0100000006007f019b9f5442464a4e524044484c505442464a4e524044484c505442464a4e524044484c5054 \
    42464a4e524044484c502a99999999999999999999999999999999999999999999000000ffffffffffffffffffff \
    ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff00ffffffffffffffffffffffff \
    ffffffffffffffffffffffffffffffffffffffffffffffffffffffffffffff158888888888888888888888000000 \
    00000000000000000000000000000000000000000101";
const ROUGH_0: &str = "\
    a01f0087f00af10a3e30887dde6a29e74fc5de5a513068cdf1253987b09591ea1ef0f7c00000881d75b61f0036f9 \
    ade8428064d5c3a8477b470fa56f2bbc309f55639628318932cc013794ffc0000030ead90a611f009e9d1903246b \
    ae35f7b258440a35b9b42214b0a1a6007dffa28cdd967af31fffc00000b1bc7af7361f000000e1ea077e5f1d1e1e \
    3b016a671c829d7c62dde510d607757ee9ce1c7625ffc000004f12b8c90f1f00125e02578736ca09858727314de1 \
    cd873759ca29d557b741121e9d08581675ffc00000092598f8ae1f00eb532f3be8febd3147795e029496276c7ac7 \
    f1062878c3a6ac1aae55a4468fffc00000d49504ae1a1f0017edecb72d9a05870e0106b5a9874e012fe505f153b3 \
    cf08133a281d2a12d7ffc00000fe3d3bb8c31f00a10339480dd9fc21c68341a4376bc421a1dd3fe13d93d2a0e67a \
    412a18e3c5ffc0000055ba14cd981f00ac330542e62e9b9b8d12b9394c8cd512c9619bbbdd42b649ac73a5a2390e \
    24ffc000009b2dcd66a61f000d4e4ea473831e723862fb808fc356b7e14715aca6ab1ddd75c0d388b9c450ffc000 \
    008717e0ab981f00cbc00d947d61bbd5ebb74b529ed7abb58120b9bcb494e0f1c717cfd327e774ffc00000accaf1 \
    66421f00ba076c5911335a2593da45b3db6f95c3a535e3e568caceb944766679143b96ffc00000599d8fd1c10000 \
    00000000000000000000000000000000000000000000d7538453aea708a7";
const ROUGH_1: &str = "\
    a1ffffff0087f00af10a3e30887dde6a29e74fc5de5a513068cdf1253987b09591ea1ef0881d0175b60036f9ade8 \
    428064d5c3a8477b470fa56f2bbc309f55639628318932cc01379430ead90a61009e9d1903246bae35f7b258440a \
    35b9b42214b0a1a6007dffa28cdd967af31fb1bc7af736000000e1ea077e5f1d1e1e3b016a671c829d7c62dde510 \
    d607757ee9ce1c76254f12b8c90f00125e02578736ca09858727314de1cd873759ca29d557b741121e9d08581675 \
    092598f8ae00eb532f3be8febd3147795e029496276c7ac7f1062878c3a6ac1aae55a4468fd49504ae1a0017edec \
    b72d9a05870e0106b5a9874e012fe505f153b3cf08133a281d2a12d7fe3d3bb8c300a10339480dd9fc21c68341a4 \
    376bc421a1dd3fe13d93d2a0e67a412a18e3c555ba14cd9800ac330542e62e9b9b8d12b9394c8cd512c9619bbbdd \
    42b649ac73a5a2390e249b2dcd66a6000d4e4ea473831e723862fb808fc356b7e14715aca6ab1ddd75c0d388b9c4 \
    508717e0ab9800cbc00d947d61bbd5ebb74b529ed7abb58120b9bcb494e0f1c717cfd327e774accaf1664200ba07 \
    6c5911335a2593da45b3db6f95c3a535e3e568caceb944766679143b96599d8fd1c1000000000000000000000000 \
    00d7538453aea708a7000000";

fn smooth() -> Vec<u8> {
    let element = |i: i32| {
        let mut bytes = ((i * 37 + i * i % 11) as u16).to_le_bytes().to_vec();
        bytes.extend(((-i * 5) as i16).to_le_bytes());
        bytes.extend((i as f32).to_le_bytes());
        bytes
    };
    (0..300).flat_map(element).collect()
}

fn rough() -> Vec<u8> {
    let value = |i: u32, k: u32| (i * i + 7 * k).wrapping_mul(2_654_435_761 >> (i % 3 * 9));
    (0..37)
        .flat_map(|i| (0..3).flat_map(move |k| value(i, k).to_le_bytes()))
        .collect()
}

#[test]
fn attributes_of_both_versions() {
    let smooth_view = view("ATTRIBUTES", "NONE", 300, 8);
    assert_eq!(decode(&unhex(SMOOTH_0), &smooth_view).unwrap(), smooth());
    assert_eq!(decode(&unhex(SMOOTH_1), &smooth_view).unwrap(), smooth());
    let rough_view = view("ATTRIBUTES", "NONE", 37, 12);
    assert_eq!(decode(&unhex(ROUGH_0), &rough_view).unwrap(), rough());
    assert_eq!(decode(&unhex(ROUGH_1), &rough_view).unwrap(), rough());
}

#[test]
fn triangles_up_to_rotation() {
    let stream = "\
    e1fe1e100e100e100ece1e160e150e140ece1e140e140e140ece1e140e140e140effffff0f0aff00290cf31118fa \
    1502007687566778a9866589689801690000";
    let mut expected: Vec<[u32; 3]> = Vec::new();
    for y in 0..4 {
        for x in 0..4 {
            let i = y * 5 + x;
            expected.extend([[i, i + 1, i + 5], [i + 5, i + 1, i + 6]]);
        }
    }
    expected.extend([[24, 3, 9], [0, 12, 24], [1, 2, 20]]);
    let bytes = decode(&unhex(stream), &view("TRIANGLES", "NONE", 105, 4)).unwrap();
    let decoded: Vec<u32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|b| u32::from_le_bytes(*b))
        .collect();
    // The encoder may turn a triangle, never turn it over.
    for (d, e) in decoded.as_chunks::<3>().0.iter().zip(&expected) {
        let turned = (0..3).any(|k| [0, 1, 2].map(|j| d[(j + k) % 3]) == *e);
        assert!(turned, "{d:?} for {e:?}");
    }
    assert_eq!(decoded.len(), 105);
}

#[test]
fn index_sequences() {
    let stream = "\
    d100a11f040b040b040b040b040b040b040b040b040b040b040b040b040b040b040b040b040b040b040b00000000";
    let expected: Vec<u16> = (0..20).flat_map(|i| [i, 1000 - i * 3]).collect();
    let bytes = decode(&unhex(stream), &view("INDICES", "NONE", 40, 2)).unwrap();
    let decoded: Vec<u16> = bytes
        .as_chunks::<2>()
        .0
        .iter()
        .map(|b| u16::from_le_bytes(*b))
        .collect();
    assert_eq!(decoded, expected);
}

fn filtered(filter: &str, stride: usize, hex: &str) -> Vec<u8> {
    let mut data = unhex(hex);
    undo(Filter::from_name(filter).unwrap(), &mut data, stride).unwrap();
    data
}

fn shorts(data: &[u8]) -> Vec<f64> {
    let value = |b: &[u8; 2]| f64::from(i16::from_le_bytes(*b)) / 32767.0;
    data.as_chunks::<2>().0.iter().map(value).collect()
}

fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < tolerance, "{found:?} {expected:?}");
    }
}

#[test]
fn filters_give_back_what_was_encoded() {
    let directions: Vec<f64> = "0.595010 0.382051 -0.707107 1.000000 0.648357 -0.705895 -0.285212 1.000000 0.376649 0.757095 0.533800 1.000000 -0.567069 0.564896 0.599437 1.000000".split(' ').map(|v| v.parse().unwrap()).collect();
    let bytes = filtered("OCTAHEDRAL", 4, "62527f7f48b37f7f1d3a7f7fd6297f7f");
    let found: Vec<f64> = bytes.iter().map(|&b| f64::from(b as i8) / 127.0).collect();
    close(&found, &directions, 0.02);
    // The fourth number passes through as it was encoded, in 12 bits here.
    let mut found = shorts(&filtered(
        "OCTAHEDRAL",
        8,
        "2f062c05ff07ff7f8e042bfbff07ff7fce01a103ff07ff7f62fd9c02ff07ff7f",
    ));
    found
        .iter_mut()
        .skip(3)
        .step_by(4)
        .for_each(|w| *w = (*w * 32767.0 / 2047.0).min(1.0));
    close(&found, &directions, 0.003);

    // A quaternion and its negative are the same turn; the encoder makes the largest component positive.
    let turns: Vec<f64> = "0.708646 0.455017 -0.336861 0.421076 0.632478 -0.688607 -0.069557 0.347784 0.225863 0.454002 0.320101 0.800252 -0.590762 0.588498 0.390301 0.390301".split(' ').map(|v| v.parse().unwrap()).collect();
    let found = shorts(&filtered(
        "QUATERNION",
        8,
        "5d5206c3384cfc7f970c0cc1838dfd7fe2282e52f139ff7f79955ab95ab9fc7f",
    ));
    for (f, e) in found.chunks_exact(4).zip(turns.chunks_exact(4)) {
        let dot: f64 = f.iter().zip(e).map(|(a, b)| a * b).sum();
        assert!((dot.abs() - 1.0).abs() < 1e-4, "{f:?} {e:?}");
    }

    let numbers = [1.5, -0.001, 12345.678, 0.0, 3e-9, -7e8];
    let bytes = filtered(
        "EXPONENTIAL",
        12,
        "300000fb000000fb360706fb0000000b0000000bdbc8fa0b",
    );
    let found: Vec<f32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|b| f32::from_le_bytes(*b))
        .collect();
    // Elements share an exponent component by component or as a whole: 20 bits below the largest.
    for (f, e) in found.iter().zip(numbers) {
        assert!((f - e).abs() <= 7e8 / 5e5, "{found:?}");
    }
    assert!(
        (found[0] - 1.5).abs() < 0.02 && (found[2] - 12345.678).abs() < 0.05,
        "{found:?}"
    );

    let colors = [0.1, 0.5, 0.9, 1.0, 0.25, 0.75, 0.0, 0.5];
    let bytes = filtered("COLOR", 4, "809a00ff6f204fc0");
    close(
        &bytes
            .iter()
            .map(|&b| f64::from(b) / 255.0)
            .collect::<Vec<_>>(),
        &colors,
        0.012,
    );
    let bytes = filtered("COLOR", 8, "00089af90000ff0fff060002ff04000c");
    let words = bytes.as_chunks::<2>().0.iter();
    let found: Vec<f64> = words
        .map(|b| f64::from(u16::from_le_bytes(*b)) / 65535.0)
        .collect();
    close(&found, &colors, 0.001);
}

#[test]
fn cut_and_overfull_streams_are_refused() {
    let whole = unhex(ROUGH_1);
    for length in 0..whole.len() {
        assert!(
            decode(&whole[..length], &view("ATTRIBUTES", "NONE", 37, 12)).is_err(),
            "{length}"
        );
    }
    assert!(decode(&whole, &view("ATTRIBUTES", "NONE", 1 << 40, 12)).is_err());
    assert!(decode(&whole, &view("TRIANGLES", "NONE", 3 << 40, 4)).is_err());
    assert!(
        decode(
            &unhex("d1000000000000"),
            &view("INDICES", "NONE", 1 << 40, 4)
        )
        .is_err()
    );
}
