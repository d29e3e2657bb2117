//! The number types that mesh formats store, and how their bytes become `f64` and `i64`.

/// Byte order of a binary file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

/// A stored number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// The type behind a name of VTU (`UInt8`) or legacy VTK (`vtktypeint64`, `double`). `long` means 64 bits, as written
    /// on today's machines.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "int8" | "signed_char" => Self::I8,
            "uint8" | "unsigned_char" => Self::U8,
            "short" | "int16" => Self::I16,
            "uint16" | "unsigned_short" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint32" | "unsigned_int" => Self::U32,
            "long" | "int64" | "vtktypeint64" | "vtkidtype" => Self::I64,
            "unsigned_long" | "uint64" | "vtktypeuint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// The number in the first `size()` of `bytes`.
    pub(super) fn real(self, bytes: &[u8], endian: Endian) -> f64 {
        match self {
            Self::F32 => f64::from(f32::from_bits(bits(bytes, 4, endian) as u32)),
            Self::F64 => f64::from_bits(bits(bytes, 8, endian)),
            Self::U64 => bits(bytes, 8, endian) as f64,
            _ => self.int(bytes, endian) as f64,
        }
    }

    /// The number in the first `size()` of `bytes`, by its bits if it is an integer: an unsigned 64-bit number beyond
    /// `i64::MAX` comes out negative, which every caller refuses. Floats are rounded towards zero.
    pub(super) fn int(self, bytes: &[u8], endian: Endian) -> i64 {
        let raw = bits(bytes, self.size(), endian);
        match self {
            Self::I8 => i64::from(raw as i8),
            Self::I16 => i64::from(raw as i16),
            Self::I32 => i64::from(raw as i32),
            Self::U8 | Self::U16 | Self::U32 | Self::I64 | Self::U64 => raw as i64,
            Self::F32 | Self::F64 => self.real(bytes, endian) as i64,
        }
    }
}

fn bits(bytes: &[u8], size: usize, endian: Endian) -> u64 {
    let mut raw = [0; 8];
    raw[..size].copy_from_slice(&bytes[..size]);
    if endian == Endian::Big {
        raw[..size].reverse();
    }
    u64::from_le_bytes(raw)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_out_of_both_byte_orders() {
        assert_eq!(Scalar::I16.int(&[0xff, 0xfe], Endian::Big), -2);
        assert_eq!(Scalar::I16.int(&[0xfe, 0xff], Endian::Little), -2);
        assert_eq!(Scalar::U16.int(&[0xff, 0xfe], Endian::Big), 0xfffe);
        assert_eq!(Scalar::F32.real(&1.5f32.to_be_bytes(), Endian::Big), 1.5);
        assert_eq!(Scalar::F64.real(&(-0.1f64).to_le_bytes(), Endian::Little), -0.1);
        assert_eq!(Scalar::U64.int(&[0xff; 8], Endian::Little), -1);
    }
}
