//! TOML values to raw specs in little code, for pages: a type is offered only what it asks for, and errors name no line and no key.
//!
//! A value that offers itself to any type, as that of the parser does, brings code for each kind of value to each type.

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
    value::Error,
};
use toml::{Table, Value};

/// A value to be read. Lists must be as long as their type, and tables are not filled from lists.
pub struct Plain(pub Value);

struct Items(std::vec::IntoIter<Value>);

struct Entries {
    rest: toml::map::IntoIter<String, Value>,
    value: Option<Value>,
}

struct Variant {
    name: String,
    content: Content,
}

/// What stands with the name of a variant.
struct Content(Option<Value>);

impl Plain {
    fn refused(&self, expected: &str) -> Error {
        let found = match &self.0 {
            Value::String(text) => Unexpected::Str(text),
            Value::Integer(number) => Unexpected::Signed(*number),
            Value::Float(number) => Unexpected::Float(*number),
            Value::Boolean(is) => Unexpected::Bool(*is),
            Value::Datetime(_) => Unexpected::Other("date"),
            Value::Array(_) => Unexpected::Seq,
            Value::Table(_) => Unexpected::Map,
        };
        Error::invalid_type(found, &expected)
    }

    fn truth(self) -> Result<bool, Error> {
        self.0.as_bool().ok_or_else(|| self.refused("true or false"))
    }

    fn whole(self) -> Result<i64, Error> {
        self.0.as_integer().ok_or_else(|| self.refused("a whole number"))
    }

    fn number(self) -> Result<f64, Error> {
        match self.0 {
            Value::Float(number) => Ok(number),
            #[allow(clippy::cast_precision_loss)]
            Value::Integer(number) => Ok(number as f64),
            _ => Err(self.refused("a number")),
        }
    }

    fn text(self) -> Result<String, Error> {
        match self.0 {
            Value::String(text) => Ok(text),
            _ => Err(self.refused("a text in quotes")),
        }
    }

    fn items(self) -> Result<Items, Error> {
        match self.0 {
            Value::Array(items) => Ok(Items(items.into_iter())),
            _ => Err(self.refused("a list")),
        }
    }

    fn entries(self) -> Result<Entries, Error> {
        match self.0 {
            Value::Table(table) => Ok(Entries::from(table)),
            _ => Err(self.refused("a table")),
        }
    }

    fn variant(self) -> Result<Variant, Error> {
        let table = match self.0 {
            Value::String(name) => return Ok(Variant { name, content: Content(None) }),
            Value::Table(table) => table,
            _ => return Err(self.refused("a word in quotes or a table")),
        };
        let mut entries = table.into_iter();
        match (entries.next(), entries.next()) {
            (Some((name, content)), None) => Ok(Variant { name, content: Content(Some(content)) }),
            _ => Err(Error::custom("expected a table with exactly one key")),
        }
    }
}

macro_rules! offer {
    ($($method:ident $visit:ident $value:ident),* $(,)?) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(self.$value()?)
        }
    )*};
}

impl<'de> Deserializer<'de> for Plain {
    type Error = Error;

    offer! {
        deserialize_bool visit_bool truth, deserialize_i64 visit_i64 whole, deserialize_u32 visit_i64 whole,
        deserialize_u64 visit_i64 whole, deserialize_f64 visit_f64 number, deserialize_str visit_string text,
        deserialize_string visit_string text, deserialize_identifier visit_string text,
        deserialize_seq visit_seq items, deserialize_map visit_map entries,
    }

    serde::forward_to_deserialize_any! {
        i8 i16 i32 i128 u8 u16 u128 f32 char bytes byte_buf unit unit_struct
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(is) => visitor.visit_bool(is),
            Value::Array(items) => visitor.visit_seq(Items(items.into_iter())),
            Value::Table(table) => visitor.visit_map(Entries::from(table)),
            Value::Datetime(_) => Err(self.refused("no date")),
        }
    }

    fn deserialize_ignored_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_unit()
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        let items = self.items()?;
        if items.0.len() != length {
            return Err(Error::custom(format!("has {} items, expected {length}", items.0.len())));
        }
        visitor.visit_seq(items)
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_map(self.entries()?)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        visitor.visit_enum(self.variant()?)
    }
}

impl<'de> SeqAccess<'de> for Items {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        self.0.next().map(|item| seed.deserialize(Plain(item))).transpose()
    }
}

impl From<Table> for Entries {
    fn from(table: Table) -> Self {
        Self { rest: table.into_iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Entries {
    type Error = Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some(value);
        seed.deserialize(Plain(Value::String(key))).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Error> {
        let value = self.value.take().ok_or_else(|| Error::custom("a value was asked for before its key"))?;
        seed.deserialize(Plain(value))
    }
}

impl<'de> EnumAccess<'de> for Variant {
    type Error = Error;
    type Variant = Content;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Content), Error> {
        Ok((seed.deserialize(Plain(Value::String(self.name)))?, self.content))
    }
}

impl Content {
    fn needed(self) -> Result<Plain, Error> {
        self.0.map(Plain).ok_or_else(|| Error::custom("wrong type, expected a table"))
    }
}

impl<'de> VariantAccess<'de> for Content {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        self.0.map_or(Ok(()), |content| Err(Plain(content).refused("a word in quotes")))
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        seed.deserialize(self.needed()?)
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Error> {
        self.needed()?.deserialize_tuple(length, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Error> {
        visitor.visit_map(self.needed()?.entries()?)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;

    use super::*;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Spec {
        name: String,
        count: Option<usize>,
        #[serde(default)]
        is_rigid: bool,
        position: [f64; 3],
        laws: Vec<Law>,
        held: BTreeMap<String, f64>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Law {
        None,
        Constant(f64),
        Linear { slope: f64 },
    }

    const WHOLE: &str = "name = 'a'\ncount = 3\nposition = [1, -2.5, inf]\n\
        laws = ['none', { constant = 2 }, { linear = { slope = 0.5 } }]\nheld = { x = 7 }";

    fn plain(text: &str) -> Result<Spec, String> {
        Spec::deserialize(Plain(Value::Table(text.parse().unwrap()))).map_err(|fault| fault.to_string())
    }

    #[test]
    fn reads_what_the_parser_reads() {
        let read = plain(WHOLE).unwrap();
        assert_eq!(read, toml::from_str(WHOLE).unwrap());
        assert_eq!(read.laws, [Law::None, Law::Constant(2.0), Law::Linear { slope: 0.5 }]);
    }

    #[test]
    fn refuses_what_is_not_asked_for() {
        for (from, to, says) in [
            ("count = 3", "count = -3", "expected usize"),
            ("count = 3", "count = 3.5", "expected a whole number"),
            ("count = 3", "size = 3", "unknown field `size`"),
            ("name = 'a'", "", "missing field `name`"),
            ("name = 'a'", "name = 1", "expected a text in quotes"),
            ("name = 'a'", "name = 2020-01-01", "invalid type: date"),
            ("-2.5, inf", "-2.5", "has 2 items, expected 3"),
            ("-2.5, inf", "-2.5, 3, 4", "has 4 items, expected 3"),
            ("{ x = 7 }", "[7]", "expected a table"),
            ("{ x = 7 }", "{ x = true }", "expected a number"),
            ("'none'", "'some'", "unknown variant `some`"),
            ("'none'", "'constant'", "wrong type, expected a table"),
            ("'none'", "{ none = 1 }", "expected a word in quotes"),
            ("{ constant = 2 }", "{ constant = 2, none = 1 }", "exactly one key"),
            ("{ slope = 0.5 }", "[0.5]", "expected a table"),
        ] {
            let said = plain(&WHOLE.replace(from, to)).unwrap_err();
            assert!(said.contains(says), "{to}: {said}");
        }
    }
}
