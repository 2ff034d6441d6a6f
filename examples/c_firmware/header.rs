//! Reads numbers out of the C headers as this library is compiled: what they say twice cannot differ, and a name that is
//! missing there is an error here.

use super::SIZES;

/// Generalised velocities.
pub const N: usize = size("STICTION_N");
/// Rows of a contact.
pub const D: usize = size("STICTION_D");
/// Dimensions of the space that contacts stand in.
pub const K: usize = if D == 2 { 2 } else { 3 };
/// Most contacts.
pub const C: usize = size("STICTION_C");
/// Most joint rows.
pub const R: usize = size("STICTION_R");
/// Most contacts with a surface.
pub const S: usize = size("STICTION_S");
/// Most limits that stay out of the scene until they are reached.
pub const L: usize = size("STICTION_L");
/// Bytes of one `stiction`.
pub const BYTES: usize = size("STICTION_BYTES");

/// The number type.
pub type Real = <Bits<{ is(SIZES, "STICTION_REAL", "double") }> as Number>::Type;

const _: () = assert!(
    is(SIZES, "STICTION_REAL", "double") || is(SIZES, "STICTION_REAL", "float"),
    "STICTION_REAL is float or double"
);

const _: () = assert!(
    D <= 3 || C.saturating_sub(S) == 0,
    "contacts with spin or roll all have a surface: where STICTION_D is 4 or 6, write STICTION_S as large as STICTION_C"
);

/// The number type by name: is it `double`?
pub struct Bits<const DOUBLE: bool>;

/// What stands behind [`Bits`].
pub trait Number {
    /// The number type.
    type Type: stiction::Real;
}

impl Number for Bits<false> {
    type Type = f32;
}

impl Number for Bits<true> {
    type Type = f64;
}

/// The type of [`PHASES`].
pub type Phases = <Choice<{ choice() }> as Chosen>::Phases;
/// What the solver goes through.
pub const PHASES: Phases = <Choice<{ choice() }> as Chosen>::PHASES;

/// The place of `STICTION_PHASES` among the choices.
const fn choice() -> usize {
    if is(SIZES, "STICTION_PHASES", "AllPhases") {
        0
    } else if is(SIZES, "STICTION_PHASES", "SweepsAndNewton") {
        1
    } else {
        assert!(
            is(SIZES, "STICTION_PHASES", "SweepsOnly"),
            "STICTION_PHASES is AllPhases, SweepsAndNewton or SweepsOnly"
        );
        2
    }
}

/// Phases by their place.
pub struct Choice<const PLACE: usize>;

/// What stands behind [`Choice`].
pub trait Chosen {
    /// Their type.
    type Phases: stiction::Phases;
    /// They themselves.
    const PHASES: Self::Phases;
}

impl Chosen for Choice<0> {
    type Phases = stiction::AllPhases;
    const PHASES: Self::Phases = stiction::AllPhases;
}

impl Chosen for Choice<1> {
    type Phases = stiction::SweepsAndNewton;
    const PHASES: Self::Phases = stiction::SweepsAndNewton;
}

impl Chosen for Choice<2> {
    type Phases = stiction::SweepsOnly;
    const PHASES: Self::Phases = stiction::SweepsOnly;
}

/// The calls and enums, in the text of `stiction.h`.
pub(super) const CALLS: &str = include_str!("stiction.h");

/// The number behind `#define NAME` or `NAME =`.
pub(super) const fn number(text: &str, name: &str) -> i32 {
    let word = word(text, name).as_bytes();
    let negative = word[0] == b'-';
    let mut at = if negative { 1 } else { 0 };
    let mut number = 0;
    assert!(word[at].is_ascii_digit(), "a header has no number behind a name, in digits and after one space");
    while at < word.len() && word[at].is_ascii_digit() {
        number = number * 10 + (word[at] - b'0') as i32;
        at += 1;
    }
    if negative { -number } else { number }
}

/// A size, which is not negative.
const fn size(name: &str) -> usize {
    let number = number(SIZES, name);
    assert!(number >= 0, "a size in stiction_sizes.h is negative");
    number as usize
}

/// Is the word behind a name this one?
const fn is(text: &str, name: &str, expected: &str) -> bool {
    starts(word(text, name).as_bytes(), 0, expected.as_bytes())
}

/// A header from the word on that stands behind `#define NAME` or `NAME =`.
const fn word<'a>(text: &'a str, name: &str) -> &'a str {
    let bytes = text.as_bytes();
    let mut at = 8;
    while at + name.len() < bytes.len() {
        if starts(bytes, at, name.as_bytes()) {
            let end = at + name.len();
            if starts(bytes, end, b" = ") {
                return text.split_at(end + 3).1;
            }
            if starts(bytes, at - 8, b"#define ") && bytes[end] == b' ' {
                return text.split_at(end + 1).1;
            }
        }
        at += 1;
    }
    panic!("a header lacks a name that header.rs or status.rs asks for")
}

/// Does a text go on with a word?
const fn starts(text: &[u8], at: usize, word: &[u8]) -> bool {
    let mut i = 0;
    while i < word.len() && at + i < text.len() && text[at + i] == word[i] {
        i += 1;
    }
    i == word.len()
}

/// A text that ends with a number, for the message of a failed build. It has spaces where digits go.
pub(super) const fn ending<const L: usize>(mut text: [u8; L], mut number: usize) -> [u8; L] {
    let mut at = L;
    while number > 0 {
        at -= 1;
        text[at] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    text
}
