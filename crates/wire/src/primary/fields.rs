//! One description of a layout for both directions: a part visits its fields in order, and what it is visited by either
//! reads them or writes them.

use super::DecodeError;

/// Reads or writes fields, one after the other.
pub(super) trait FieldCodec {
    /// A byte.
    fn u8(&mut self, value: &mut u8) -> Result<(), DecodeError>;
    /// Four bytes without a sign.
    fn u32(&mut self, value: &mut u32) -> Result<(), DecodeError>;
    /// Eight bytes without a sign.
    fn u64(&mut self, value: &mut u64) -> Result<(), DecodeError>;

    /// A truth value in a byte.
    fn flag(&mut self, value: &mut bool) -> Result<(), DecodeError> {
        let mut byte = u8::from(*value);
        self.u8(&mut byte)?;
        *value = byte != 0;
        Ok(())
    }

    /// Four bytes with a sign.
    fn i32(&mut self, value: &mut i32) -> Result<(), DecodeError> {
        let mut bits = value.cast_unsigned();
        self.u32(&mut bits)?;
        *value = bits.cast_signed();
        Ok(())
    }

    /// A number of single precision.
    fn f32(&mut self, value: &mut f32) -> Result<(), DecodeError> {
        let mut bits = value.to_bits();
        self.u32(&mut bits)?;
        *value = f32::from_bits(bits);
        Ok(())
    }

    /// A number.
    fn f64(&mut self, value: &mut f64) -> Result<(), DecodeError> {
        let mut bits = value.to_bits();
        self.u64(&mut bits)?;
        *value = f64::from_bits(bits);
        Ok(())
    }

    /// Floating-point numbers of eight bytes each.
    fn f64s(&mut self, values: &mut [f64]) -> Result<(), DecodeError> {
        values.iter_mut().try_for_each(|value| self.f64(value))
    }

    /// Bytes.
    fn bytes(&mut self, values: &mut [u8]) -> Result<(), DecodeError> {
        values.iter_mut().try_for_each(|value| self.u8(value))
    }
}

/// Reads fields from bytes.
pub(super) struct FieldReader<'a> {
    rest: &'a [u8],
}

impl<'a> FieldReader<'a> {
    /// A reader of the fields in these bytes.
    pub(super) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// What has not been read.
    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let Some((field, rest)) = self.rest.split_first_chunk::<N>() else {
            let missing = N - self.rest.len();
            return Err(DecodeError::UnexpectedEnd { missing });
        };
        self.rest = rest;
        Ok(*field)
    }
}

impl FieldCodec for FieldReader<'_> {
    fn u8(&mut self, value: &mut u8) -> Result<(), DecodeError> {
        [*value] = self.take::<1>()?;
        Ok(())
    }

    fn u32(&mut self, value: &mut u32) -> Result<(), DecodeError> {
        *value = u32::from_be_bytes(self.take()?);
        Ok(())
    }

    fn u64(&mut self, value: &mut u64) -> Result<(), DecodeError> {
        *value = u64::from_be_bytes(self.take()?);
        Ok(())
    }
}

/// Writes fields behind what is there. Never fails.
pub(super) struct FieldWriter<'a>(pub(super) &'a mut Vec<u8>);

impl FieldCodec for FieldWriter<'_> {
    fn u8(&mut self, value: &mut u8) -> Result<(), DecodeError> {
        self.0.push(*value);
        Ok(())
    }

    fn u32(&mut self, value: &mut u32) -> Result<(), DecodeError> {
        self.0.extend(value.to_be_bytes());
        Ok(())
    }

    fn u64(&mut self, value: &mut u64) -> Result<(), DecodeError> {
        self.0.extend(value.to_be_bytes());
        Ok(())
    }
}

/// Appends a length that counts itself, a type, and what `fill` appends.
pub(super) fn append_length_prefixed(out: &mut Vec<u8>, kind: u8, fill: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend([0; 4]);
    out.push(kind);
    fill(out);
    // Texts and parts are bounded, so a length always fits.
    let length = u32::try_from(out.len() - start).unwrap_or(u32::MAX);
    out[start..start + 4].copy_from_slice(&length.to_be_bytes());
}
