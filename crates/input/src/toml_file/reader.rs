//! A deserializer from parsed TOML to raw specs that compiles to little code: it offers a type only what that asks for.
//!
//! A value that offers itself to any type, as that of the parser does, brings code for each kind of value to each type.
//! Here lists are exactly as long as their type says, and tables are not filled from lists.

use std::fmt;
use std::ops::Range;

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, Expected, MapAccess, SeqAccess, Unexpected, VariantAccess,
    Visitor,
};
use toml::Spanned;
use toml::de::{DeInteger, DeString, DeTable, DeValue};

/// A parsing error: the message, the position in the text, and the key.
#[derive(Debug)]
pub struct Fault(Box<FaultParts>);

/// The contents of a [`Fault`].
#[derive(Debug)]
struct FaultParts {
    message: String,
    span: Option<Range<usize>>,
    /// Innermost first.
    path: Vec<Step>,
}

/// A step of a key path: a key, or an item of a list.
#[derive(Debug)]
enum Step {
    Key(String),
    Item(usize),
}

type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    /// Returns the bytes of the text at fault; `None` if they are not known.
    pub fn span(&self) -> Option<Range<usize>> {
        self.0.span.clone()
    }

    /// Returns the path of the key, such as `chains[0].base`; empty for the whole file.
    pub fn key(&self) -> String {
        let mut key = String::new();
        for step in self.0.path.iter().rev() {
            match step {
                Step::Item(index) => key += &format!("[{index}]"),
                Step::Key(name) if key.is_empty() => key += name,
                Step::Key(name) => key += &format!(".{name}"),
            }
        }
        key
    }

    /// Sets the position to the bytes `span` of the text, unless the fault has one already.
    fn with_span(mut self, span: &Range<usize>) -> Self {
        self.0.span.get_or_insert_with(|| span.clone());
        self
    }

    /// Puts `step` in front of the key path.
    fn with_step(mut self, step: Step) -> Self {
        self.0.path.push(step);
        self
    }
}

impl Error for Fault {
    /// Creates a fault with a message and no position.
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(Box::new(FaultParts { message: message.to_string(), span: None, path: Vec::new() }))
    }
}

impl fmt::Display for Fault {
    /// Writes the message.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.0.message)
    }
}

impl std::error::Error for Fault {}

/// A TOML value to be deserialized, with its bytes in the text.
pub struct Reader<'a> {
    value: DeValue<'a>,
    span: Range<usize>,
}

/// The items of a list that are still to be read.
struct Items<'a> {
    rest: std::vec::IntoIter<Spanned<DeValue<'a>>>,
    next: usize,
}

/// The entries of a table that are still to be read.
struct Entries<'a> {
    rest: toml::map::IntoIter<Spanned<DeString<'a>>, Spanned<DeValue<'a>>>,
    value: Option<(DeString<'a>, Spanned<DeValue<'a>>)>,
}

/// The name of an enum's variant and its content, if it has any.
struct Variant<'a> {
    name: Reader<'a>,
    content: Option<Spanned<DeValue<'a>>>,
}

/// The content of a variant, with the variant's name for errors.
struct Content<'a> {
    variant: String,
    value: Option<Reader<'a>>,
}

impl<'a> From<Spanned<DeTable<'a>>> for Reader<'a> {
    /// Creates the reader of a whole file or table.
    fn from(table: Spanned<DeTable<'a>>) -> Self {
        Self { span: table.span(), value: DeValue::Table(table.into_inner()) }
    }
}

impl<'a> From<Spanned<DeValue<'a>>> for Reader<'a> {
    /// Creates the reader of a value.
    fn from(value: Spanned<DeValue<'a>>) -> Self {
        Self { span: value.span(), value: value.into_inner() }
    }
}

impl<'a> Reader<'a> {
    /// Deserializes the value by `seed`.
    pub fn read<S: DeserializeSeed<'a>>(self, seed: S) -> Result<S::Value> {
        self.with_position(|value| seed.deserialize(value))
    }

    /// Applies `read` to the value; its faults get the value's position.
    fn with_position<T>(self, read: impl FnOnce(Self) -> Result<T>) -> Result<T> {
        let span = self.span.clone();
        read(self).map_err(|fault| fault.with_span(&span))
    }

    /// Returns the error that the value is not of the `expected` type.
    fn type_fault(&self, expected: &dyn Expected) -> Fault {
        let actual = match &self.value {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Integer(number) => match parse_integer(number) {
                Ok(number) => Unexpected::Signed(number),
                Err(fault) => return fault,
            },
            DeValue::Float(number) => match number.as_str().parse() {
                Ok(number) => Unexpected::Float(number),
                Err(_) => Unexpected::Other("number"),
            },
            DeValue::Boolean(is) => Unexpected::Bool(*is),
            DeValue::Datetime(_) => Unexpected::Other("date"),
            DeValue::Array(_) => Unexpected::Seq,
            DeValue::Table(_) => Unexpected::Map,
        };
        Fault::invalid_type(actual, expected)
    }

    /// Returns the value as a boolean.
    fn boolean(self, expected: &dyn Expected) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.type_fault(expected))
    }

    /// Returns the value as a whole number.
    fn integer(self, expected: &dyn Expected) -> Result<i64> {
        match &self.value {
            DeValue::Integer(number) => parse_integer(number),
            _ => Err(self.type_fault(expected)),
        }
    }

    /// Returns the value as a number; whole numbers count.
    fn number(self, expected: &dyn Expected) -> Result<f64> {
        match &self.value {
            DeValue::Float(number) => {
                let value: f64 = number.as_str().parse().map_err(|_| self.type_fault(expected))?;
                if value.is_infinite() && !number.as_str().contains("inf") {
                    return Err(Fault::custom("number too large"));
                }
                Ok(value)
            }
            #[allow(clippy::cast_precision_loss)]
            DeValue::Integer(number) => parse_integer(number).map(|number| number as f64),
            _ => Err(self.type_fault(expected)),
        }
    }

    /// Returns the value as a text.
    fn text(self, expected: &dyn Expected) -> Result<String> {
        match self.value {
            DeValue::String(text) => Ok(text.into_owned()),
            _ => Err(self.type_fault(expected)),
        }
    }

    /// Returns the items of the value, a list.
    fn items(self, expected: &dyn Expected) -> Result<Items<'a>> {
        match self.value {
            DeValue::Array(items) => Ok(Items { rest: items.into_iter(), next: 0 }),
            _ => Err(self.type_fault(expected)),
        }
    }

    /// Returns the items of the value, a list of exactly `length`.
    fn items_of_length(self, length: usize, expected: &dyn Expected) -> Result<Items<'a>> {
        let items = self.items(expected)?;
        match items.rest.len() {
            count if count == length => Ok(items),
            count => Err(Fault::custom(length_message(count, length))),
        }
    }

    /// Returns the entries of the value, a table.
    fn entries(self, expected: &dyn Expected) -> Result<Entries<'a>> {
        match self.value {
            DeValue::Table(table) => Ok(Entries { rest: table.into_iter(), value: None }),
            _ => Err(self.type_fault(expected)),
        }
    }

    /// Returns the value as a variant of an enum: a text, or a table with one key.
    fn variant(self) -> Result<Variant<'a>> {
        let table = match self.value {
            DeValue::String(_) => return Ok(Variant { name: self, content: None }),
            DeValue::Table(table) => table,
            _ => return Err(Fault::custom("wrong type, expected a word in quotes or a table")),
        };
        let mut entries = table.into_iter();
        match (entries.next(), entries.next()) {
            (Some((name, content)), None) => Ok(Variant { name: key_reader(name), content: Some(content) }),
            _ => Err(Fault::custom("expected a table with exactly one key")),
        }
    }
}

/// Returns a reader of the name of a key, as a text value.
fn key_reader(name: Spanned<DeString>) -> Reader {
    Reader { span: name.span(), value: DeValue::String(name.into_inner()) }
}

/// Parses a whole number of any notation.
fn parse_integer(number: &DeInteger) -> Result<i64> {
    i64::from_str_radix(number.as_str(), number.radix()).map_err(|_| Fault::custom("whole number too large"))
}

/// Returns the message that a list has another length than expected.
fn length_message(count: usize, expected: usize) -> String {
    let items = if count == 1 { "item" } else { "items" };
    let hint = if count == 2 * expected { "; decimals are written with a point: 0.5, not 0,5" } else { "" };
    format!("has {count} {items}, expected {expected}{hint}")
}

macro_rules! offer {
    ($($method:ident $visit:ident $value:ident),* $(,)?) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
            let value = self.$value(&visitor)?;
            visitor.$visit(value)
        }
    )*};
}

impl<'de> Deserializer<'de> for Reader<'de> {
    type Error = Fault;

    offer! {
        deserialize_bool visit_bool boolean, deserialize_i64 visit_i64 integer, deserialize_u32 visit_i64 integer,
        deserialize_u64 visit_i64 integer, deserialize_f64 visit_f64 number, deserialize_str visit_string text,
        deserialize_string visit_string text, deserialize_identifier visit_string text,
        deserialize_seq visit_seq items, deserialize_map visit_map entries,
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i128 u8 u16 u128 f32 char bytes byte_buf unit unit_struct
    }

    /// Offers the value as what it is in the file; dates are refused.
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        match &self.value {
            DeValue::String(_) => self.deserialize_string(visitor),
            DeValue::Integer(_) => self.deserialize_i64(visitor),
            DeValue::Float(_) => self.deserialize_f64(visitor),
            DeValue::Boolean(_) => self.deserialize_bool(visitor),
            DeValue::Array(_) => self.deserialize_seq(visitor),
            DeValue::Table(_) => self.deserialize_map(visitor),
            DeValue::Datetime(_) => Err(self.type_fault(&"no date")),
        }
    }

    /// Skips the value.
    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_unit()
    }

    /// Offers the value as one that is given: keys that are missing are never read.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value> {
        visitor.visit_newtype_struct(self)
    }

    /// Reads a list of exactly `length` items.
    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value> {
        let items = self.items_of_length(length, &visitor)?;
        visitor.visit_seq(items)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(self, _: &'static str, length: usize, visitor: V) -> Result<V::Value> {
        self.deserialize_tuple(length, visitor)
    }

    /// Reads a table.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        self.deserialize_map(visitor)
    }

    /// Reads a text, or a table with one key, as a variant.
    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        visitor.visit_enum(self.variant()?)
    }
}

impl<'de> SeqAccess<'de> for Items<'de> {
    type Error = Fault;

    /// Reads the next item of the list, with its index in the key path of faults.
    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        let Some(item) = self.rest.next() else { return Ok(None) };
        let index = self.next;
        self.next += 1;
        Reader::from(item).read(seed).map(Some).map_err(|fault| fault.with_step(Step::Item(index)))
    }

    /// Returns the number of items left, never `None`.
    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Fault;

    /// Reads the next key of the table and keeps its value.
    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        let Some((name, value)) = self.rest.next() else { return Ok(None) };
        let text = name.get_ref().clone();
        match key_reader(name).read(seed) {
            Ok(key) => {
                self.value = Some((text, value));
                Ok(Some(key))
            }
            Err(fault) => Err(fault.with_step(Step::Key(text.into_owned()))),
        }
    }

    /// Reads the value of the last key, with the key in the path of faults.
    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value> {
        let (name, value) = self.value.take().ok_or_else(|| Fault::custom("a value was asked for before its key"))?;
        Reader::from(value).read(seed).map_err(|fault| fault.with_step(Step::Key(name.into_owned())))
    }
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Fault;
    type Variant = Content<'de>;

    /// Reads the variant's name and returns it with the content.
    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Content<'de>)> {
        let variant = self.name.value.as_str().unwrap_or_default().to_string();
        let value = self.content.map(Reader::from);
        Ok((self.name.read(seed)?, Content { variant, value }))
    }
}

impl<'de> Content<'de> {
    /// Applies `read` to the content; its faults get the variant's key.
    fn read<T>(self, read: impl FnOnce(Reader<'de>) -> Result<T>) -> Result<T> {
        let Some(value) = self.value else { return Err(Fault::custom("wrong type, expected a table")) };
        value.with_position(read).map_err(|fault| fault.with_step(Step::Key(self.variant)))
    }
}

impl<'de> VariantAccess<'de> for Content<'de> {
    type Error = Fault;

    /// Checks that the variant has no content.
    fn unit_variant(self) -> Result<()> {
        match self.value {
            None => Ok(()),
            Some(_) => self.read(|value| Err(value.type_fault(&"a word in quotes"))),
        }
    }

    /// Reads the content of the variant by `seed`.
    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value> {
        self.read(|value| seed.deserialize(value))
    }

    /// Reads the content of the variant as a list of `length` items.
    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value> {
        self.read(|value| value.deserialize_tuple(length, visitor))
    }

    /// Reads the content of the variant as a table.
    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value> {
        self.read(|value| value.deserialize_map(visitor))
    }
}
