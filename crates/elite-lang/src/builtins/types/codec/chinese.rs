//! GB 2312, GBK and GB 18030. The table of two bytes a character is encoding_rs's, whose edition of GB 18030 is that of
//! 2022; what the edition CPython has (2000) means by a few codes stands here. GBK is that table without what GB 18030
//! has added, GB 2312 a part of GBK.

use std::sync::OnceLock;

/// The encodings that this table serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GbEncoding {
    Gb2312,
    Gbk,
    Gb18030,
}

/// What does not decode: how many bytes, and whether more of them would help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GbDecodeError {
    Illegal,
    Incomplete,
}

/// Codes whose character in CPython's edition is another one.
const OTHERS: &[(u16, u16)] = &[
    (0xa3a0, 0xe5e5),
    (0xa6d9, 0xe78d),
    (0xa6da, 0xe78e),
    (0xa6db, 0xe78f),
    (0xa6dc, 0xe790),
    (0xa6dd, 0xe791),
    (0xa6de, 0xe792),
    (0xa6df, 0xe793),
    (0xa6ec, 0xe794),
    (0xa6ed, 0xe795),
    (0xa6f3, 0xe796),
    (0xa8bc, 0xe7c7),
    (0xfe59, 0xe81e),
    (0xfe61, 0xe826),
    (0xfe66, 0xe82b),
    (0xfe67, 0xe82c),
    (0xfe6d, 0xe832),
    (0xfe7e, 0xe843),
    (0xfe90, 0xe854),
    (0xfea0, 0xe864),
];

/// Codes, by ranges, that GB 18030 has added to GBK.
const ADDED: &[(u16, u16)] = &[
    (0xa140, 0xa1a0),
    (0xa240, 0xa2a0),
    (0xa2ab, 0xa2b0),
    (0xa2e3, 0xa2e4),
    (0xa2ef, 0xa2f0),
    (0xa2fd, 0xa2fe),
    (0xa340, 0xa3a0),
    (0xa440, 0xa4a0),
    (0xa4f4, 0xa4fe),
    (0xa540, 0xa5a0),
    (0xa5f7, 0xa5fe),
    (0xa640, 0xa6a0),
    (0xa6b9, 0xa6c0),
    (0xa6d9, 0xa6df),
    (0xa6ec, 0xa6ed),
    (0xa6f3, 0xa6f3),
    (0xa6f6, 0xa6fe),
    (0xa740, 0xa7a0),
    (0xa7c2, 0xa7d0),
    (0xa7f2, 0xa7fe),
    (0xa896, 0xa8a0),
    (0xa8bc, 0xa8bc),
    (0xa8bf, 0xa8bf),
    (0xa8c1, 0xa8c4),
    (0xa8ea, 0xa8fe),
    (0xa958, 0xa958),
    (0xa95b, 0xa95b),
    (0xa95d, 0xa95f),
    (0xa989, 0xa995),
    (0xa997, 0xa9a3),
    (0xa9f0, 0xa9fe),
    (0xaaa1, 0xaafe),
    (0xaba1, 0xabfe),
    (0xaca1, 0xacfe),
    (0xada1, 0xadfe),
    (0xaea1, 0xaefe),
    (0xafa1, 0xaffe),
    (0xd7fa, 0xd7fe),
    (0xf8a1, 0xf8fe),
    (0xf9a1, 0xf9fe),
    (0xfaa1, 0xfafe),
    (0xfba1, 0xfbfe),
    (0xfca1, 0xfcfe),
    (0xfda1, 0xfdfe),
    (0xfe50, 0xfefe),
];

/// Codes, by ranges, in the area of GB 2312 that GBK has added.
const BEYOND_2312: &[(u16, u16)] = &[
    (0xa2a1, 0xa2aa),
    (0xa6e0, 0xa6eb),
    (0xa6ee, 0xa6f2),
    (0xa6f4, 0xa6f5),
    (0xa8bb, 0xa8bb),
    (0xa8bd, 0xa8be),
    (0xa8c0, 0xa8c0),
];

/// What GB 2312 means otherwise than GBK.
const OF_2312: [(u16, u16); 2] = [(0xa1a4, 0x30fb), (0xa1aa, 0x2015)];

/// Second bytes: 0x40 to 0xfe.
const ROW: usize = 0xbf;

struct GbTables {
    /// The character of each code, by rows; 0 where there is none.
    decoded: Vec<u16>,
    /// The code of each character of the first plane; 0 where there is none.
    encoded: Vec<u16>,
    /// The characters of the first plane that take four bytes, in order.
    long: Vec<u16>,
}

fn tables() -> &'static GbTables {
    static TABLES: OnceLock<GbTables> = OnceLock::new();
    // The tables outlive the task that needs them first, so they do not count as its memory.
    TABLES.get_or_init(|| task_memory::uncounted(GbTables::make))
}

impl GbTables {
    fn make() -> Self {
        let mut decoded = vec![0u16; (0xff - 0x81) * ROW];
        let mut encoded = vec![0u16; 0x1_0000];
        for lead in 0x81..=0xfeu8 {
            for second in (0x40..=0xfeu8).filter(|byte| *byte != 0x7f) {
                let code = u16::from_be_bytes([lead, second]);
                let other = OTHERS.iter().find(|(of, _)| *of == code);
                let c = other.map(|(_, c)| *c).or_else(|| standard(lead, second));
                if let Some(c) = c {
                    decoded[place(code)] = c;
                    encoded[usize::from(c)] = code;
                }
            }
        }
        let long = (0x80..=0xffffu16)
            .filter(|c| !(0xd800..0xe000).contains(c) && encoded[usize::from(*c)] == 0);
        let long = long.collect();
        GbTables {
            decoded,
            encoded,
            long,
        }
    }
}

fn place(code: u16) -> usize {
    let [lead, second] = code.to_be_bytes();
    usize::from(lead - 0x81) * ROW + usize::from(second - 0x40)
}

/// What encoding_rs makes of two bytes.
fn standard(lead: u8, second: u8) -> Option<u16> {
    let bytes = [lead, second];
    let text = encoding_rs::GB18030.decode_without_bom_handling_and_without_replacement(&bytes)?;
    let mut chars = text.chars();
    let c = chars.next().filter(|_| chars.next().is_none())?;
    u16::try_from(c as u32).ok()
}

fn is_in(ranges: &[(u16, u16)], code: u16) -> bool {
    ranges
        .iter()
        .any(|(first, last)| (*first..=*last).contains(&code))
}

impl GbEncoding {
    /// What CPython calls it.
    pub fn name(self) -> &'static str {
        match self {
            GbEncoding::Gb2312 => "gb2312",
            GbEncoding::Gbk => "gbk",
            GbEncoding::Gb18030 => "gb18030",
        }
    }

    fn has(self, code: u16) -> bool {
        let [lead, second] = code.to_be_bytes();
        match self {
            GbEncoding::Gb18030 => true,
            GbEncoding::Gbk => !is_in(ADDED, code),
            GbEncoding::Gb2312 => {
                (0xa1..=0xf7).contains(&lead)
                    && second >= 0xa1
                    && !is_in(ADDED, code)
                    && !is_in(BEYOND_2312, code)
            }
        }
    }

    /// The first character of bytes, which are not ASCII there, and how many it takes.
    pub fn decode(self, bytes: &[u8]) -> Result<(char, usize), GbDecodeError> {
        let lead = bytes[0];
        let Some(second) = bytes.get(1).copied() else {
            return Err(GbDecodeError::Incomplete);
        };
        if !(0x81..=0xfe).contains(&lead) {
            return Err(GbDecodeError::Illegal);
        }
        if self == GbEncoding::Gb18030 && second.is_ascii_digit() {
            return decode_long(bytes);
        }
        if !(0x40..=0xfe).contains(&second) {
            return Err(GbDecodeError::Illegal);
        }
        let code = u16::from_be_bytes([lead, second]);
        let of_2312 = OF_2312
            .iter()
            .find(|(of, _)| self == GbEncoding::Gb2312 && *of == code);
        let c = match of_2312 {
            Some((_, c)) => *c,
            None if self.has(code) => tables().decoded[place(code)],
            None => 0,
        };
        match char::from_u32(u32::from(c)) {
            Some(c) if c != '\0' => Ok((c, 2)),
            _ => Err(GbDecodeError::Illegal),
        }
    }

    /// Appends the bytes of a character that is not ASCII; false if it has none.
    pub fn encode(self, c: char, out: &mut Vec<u8>) -> bool {
        let code = c as u32;
        let short = match u16::try_from(code) {
            Ok(code) => {
                let of_2312 = OF_2312.iter().filter(|_| self == GbEncoding::Gb2312);
                let mut of_2312 =
                    of_2312.filter(|(of, c)| *c == code || tables().decoded[place(*of)] == code);
                match of_2312.next() {
                    Some((of, c)) => u16::from(*c == code) * of,
                    None => tables().encoded[usize::from(code)],
                }
            }
            Err(_) => 0,
        };
        if short != 0 && self.has(short) {
            out.extend_from_slice(&short.to_be_bytes());
            return true;
        }
        if self != GbEncoding::Gb18030 {
            return false;
        }
        let number = match u16::try_from(code) {
            Ok(code) => match tables().long.binary_search(&code) {
                Ok(number) => number as u32,
                Err(_) => return false,
            },
            Err(_) => code - 0x1_0000 + SUPPLEMENTARY,
        };
        let digit = |number: u32| 0x30 + (number % 10) as u8;
        let byte = |number: u32| 0x81 + (number % 126) as u8;
        out.extend_from_slice(&[
            0x81 + (number / 12_600) as u8,
            digit(number / 1260),
            byte(number / 10),
            digit(number),
        ]);
        true
    }
}

/// The number, in codes of four bytes, of the first character beyond the first plane.
const SUPPLEMENTARY: u32 = (0x90 - 0x81) * 12_600;

fn decode_long(bytes: &[u8]) -> Result<(char, usize), GbDecodeError> {
    let [a, b, c, d] = match bytes {
        [a, b, c, d, ..] => [*a, *b, *c, *d],
        _ => return Err(GbDecodeError::Incomplete),
    };
    if !(0x81..=0xfe).contains(&c) || !d.is_ascii_digit() {
        return Err(GbDecodeError::Illegal);
    }
    let part = |byte: u8, from: u8| u32::from(byte - from);
    let number = ((part(a, 0x81) * 10 + part(b, 0x30)) * 126 + part(c, 0x81)) * 10 + part(d, 0x30);
    let code = match number {
        SUPPLEMENTARY.. => Some(number - SUPPLEMENTARY + 0x1_0000),
        _ => tables()
            .long
            .get(number as usize)
            .map(|code| u32::from(*code)),
    };
    let c = code
        .and_then(char::from_u32)
        .ok_or(GbDecodeError::Illegal)?;
    Ok((c, 4))
}
