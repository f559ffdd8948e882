//! Parsed TOML to raw specs, in little code: one deserializer for every file, which offers a type only what it asks for.
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

/// What is wrong, where in the text, and at which key.
#[derive(Debug)]
pub struct Fault(Box<Parts>);

#[derive(Debug)]
struct Parts {
    message: String,
    span: Option<Range<usize>>,
    /// Innermost first.
    path: Vec<Step>,
}

#[derive(Debug)]
enum Step {
    Key(String),
    Item(usize),
}

type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    /// Bytes of the text, where known.
    pub fn span(&self) -> Option<Range<usize>> {
        self.0.span.clone()
    }

    /// The path of the key, such as `chains[0].base`; empty for the whole file.
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

    /// As a fault of what stands at `span`, unless it is one of something within.
    fn at(mut self, span: &Range<usize>) -> Self {
        self.0.span.get_or_insert_with(|| span.clone());
        self
    }

    fn inside(mut self, step: Step) -> Self {
        self.0.path.push(step);
        self
    }
}

impl Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(Box::new(Parts { message: message.to_string(), span: None, path: Vec::new() }))
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.0.message)
    }
}

impl std::error::Error for Fault {}

/// A value to be read, with its place in the text.
pub struct Reader<'a> {
    value: DeValue<'a>,
    span: Range<usize>,
}

struct Items<'a> {
    rest: std::vec::IntoIter<Spanned<DeValue<'a>>>,
    next: usize,
}

struct Entries<'a> {
    rest: toml::map::IntoIter<Spanned<DeString<'a>>, Spanned<DeValue<'a>>>,
    value: Option<(DeString<'a>, Spanned<DeValue<'a>>)>,
}

struct Variant<'a> {
    name: Reader<'a>,
    content: Option<Spanned<DeValue<'a>>>,
}

/// What stands with the name of a variant.
struct Content<'a> {
    variant: String,
    value: Option<Reader<'a>>,
}

impl<'a> From<Spanned<DeTable<'a>>> for Reader<'a> {
    fn from(table: Spanned<DeTable<'a>>) -> Self {
        Self { span: table.span(), value: DeValue::Table(table.into_inner()) }
    }
}

impl<'a> From<Spanned<DeValue<'a>>> for Reader<'a> {
    fn from(value: Spanned<DeValue<'a>>) -> Self {
        Self { span: value.span(), value: value.into_inner() }
    }
}

impl<'a> Reader<'a> {
    /// The value, as the type wants it.
    pub fn read<S: DeserializeSeed<'a>>(self, seed: S) -> Result<S::Value> {
        self.with(|own| seed.deserialize(own))
    }

    /// What `read` makes of the value, with faults at its place.
    fn with<T>(self, read: impl FnOnce(Self) -> Result<T>) -> Result<T> {
        let span = self.span.clone();
        read(self).map_err(|fault| fault.at(&span))
    }

    fn refused(&self, wanted: &dyn Expected) -> Fault {
        let found = match &self.value {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Integer(number) => match signed(number) {
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
        Fault::invalid_type(found, wanted)
    }

    fn truth(self, wanted: &dyn Expected) -> Result<bool> {
        self.value.as_bool().ok_or_else(|| self.refused(wanted))
    }

    fn whole(self, wanted: &dyn Expected) -> Result<i64> {
        match &self.value {
            DeValue::Integer(number) => signed(number),
            _ => Err(self.refused(wanted)),
        }
    }

    fn number(self, wanted: &dyn Expected) -> Result<f64> {
        match &self.value {
            DeValue::Float(number) => {
                let value: f64 = number.as_str().parse().map_err(|_| self.refused(wanted))?;
                if value.is_infinite() && !number.as_str().contains("inf") {
                    return Err(Fault::custom("number too large"));
                }
                Ok(value)
            }
            #[allow(clippy::cast_precision_loss)]
            DeValue::Integer(number) => signed(number).map(|number| number as f64),
            _ => Err(self.refused(wanted)),
        }
    }

    fn text(self, wanted: &dyn Expected) -> Result<String> {
        match self.value {
            DeValue::String(text) => Ok(text.into_owned()),
            _ => Err(self.refused(wanted)),
        }
    }

    fn items(self, wanted: &dyn Expected) -> Result<Items<'a>> {
        match self.value {
            DeValue::Array(items) => Ok(Items { rest: items.into_iter(), next: 0 }),
            _ => Err(self.refused(wanted)),
        }
    }

    fn items_of(self, length: usize, wanted: &dyn Expected) -> Result<Items<'a>> {
        let items = self.items(wanted)?;
        match items.rest.len() {
            found if found == length => Ok(items),
            found => Err(Fault::custom(other_length(found, length))),
        }
    }

    fn entries(self, wanted: &dyn Expected) -> Result<Entries<'a>> {
        match self.value {
            DeValue::Table(table) => Ok(Entries { rest: table.into_iter(), value: None }),
            _ => Err(self.refused(wanted)),
        }
    }

    fn variant(self) -> Result<Variant<'a>> {
        let table = match self.value {
            DeValue::String(_) => return Ok(Variant { name: self, content: None }),
            DeValue::Table(table) => table,
            _ => return Err(Fault::custom("wrong type, expected a word in quotes or a table")),
        };
        let mut entries = table.into_iter();
        match (entries.next(), entries.next()) {
            (Some((name, content)), None) => Ok(Variant { name: key(name), content: Some(content) }),
            _ => Err(Fault::custom("expected a table with exactly one key")),
        }
    }
}

/// The name of a key, as a value.
fn key(name: Spanned<DeString>) -> Reader {
    Reader { span: name.span(), value: DeValue::String(name.into_inner()) }
}

fn signed(number: &DeInteger) -> Result<i64> {
    i64::from_str_radix(number.as_str(), number.radix()).map_err(|_| Fault::custom("whole number too large"))
}

fn other_length(found: usize, expected: usize) -> String {
    let items = if found == 1 { "item" } else { "items" };
    let hint = if found == 2 * expected { "; decimals are written with a point: 0.5, not 0,5" } else { "" };
    format!("has {found} {items}, expected {expected}{hint}")
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
        deserialize_bool visit_bool truth, deserialize_i64 visit_i64 whole, deserialize_u32 visit_i64 whole,
        deserialize_u64 visit_i64 whole, deserialize_f64 visit_f64 number, deserialize_str visit_string text,
        deserialize_string visit_string text, deserialize_identifier visit_string text,
        deserialize_seq visit_seq items, deserialize_map visit_map entries,
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i128 u8 u16 u128 f32 char bytes byte_buf unit unit_struct
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        match &self.value {
            DeValue::String(_) => self.deserialize_string(visitor),
            DeValue::Integer(_) => self.deserialize_i64(visitor),
            DeValue::Float(_) => self.deserialize_f64(visitor),
            DeValue::Boolean(_) => self.deserialize_bool(visitor),
            DeValue::Array(_) => self.deserialize_seq(visitor),
            DeValue::Table(_) => self.deserialize_map(visitor),
            DeValue::Datetime(_) => Err(self.refused(&"no date")),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value> {
        let items = self.items_of(length, &visitor)?;
        visitor.visit_seq(items)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(self, _: &'static str, length: usize, visitor: V) -> Result<V::Value> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        self.deserialize_map(visitor)
    }

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

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        let Some(item) = self.rest.next() else { return Ok(None) };
        let index = self.next;
        self.next += 1;
        Reader::from(item).read(seed).map(Some).map_err(|fault| fault.inside(Step::Item(index)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = Fault;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        let Some((name, value)) = self.rest.next() else { return Ok(None) };
        let text = name.get_ref().clone();
        match key(name).read(seed) {
            Ok(key) => {
                self.value = Some((text, value));
                Ok(Some(key))
            }
            Err(fault) => Err(fault.inside(Step::Key(text.into_owned()))),
        }
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value> {
        let (name, value) = self.value.take().ok_or_else(|| Fault::custom("a value was asked for before its key"))?;
        Reader::from(value).read(seed).map_err(|fault| fault.inside(Step::Key(name.into_owned())))
    }
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = Fault;
    type Variant = Content<'de>;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Content<'de>)> {
        let variant = self.name.value.as_str().unwrap_or_default().to_string();
        let value = self.content.map(Reader::from);
        Ok((self.name.read(seed)?, Content { variant, value }))
    }
}

impl<'de> Content<'de> {
    /// What `read` makes of the content, with faults at the variant.
    fn read<T>(self, read: impl FnOnce(Reader<'de>) -> Result<T>) -> Result<T> {
        let Some(value) = self.value else { return Err(Fault::custom("wrong type, expected a table")) };
        value.with(read).map_err(|fault| fault.inside(Step::Key(self.variant)))
    }
}

impl<'de> VariantAccess<'de> for Content<'de> {
    type Error = Fault;

    fn unit_variant(self) -> Result<()> {
        match self.value {
            None => Ok(()),
            Some(_) => self.read(|value| Err(value.refused(&"a word in quotes"))),
        }
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value> {
        self.read(|value| seed.deserialize(value))
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value> {
        self.read(|value| value.deserialize_tuple(length, visitor))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value> {
        self.read(|value| value.deserialize_map(visitor))
    }
}
