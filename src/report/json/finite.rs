//! Refuses numbers that are not finite: JSON knows none, and serde_json would write null for them.

use serde::ser::{
    Error as _, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant,
    SerializeTuple, SerializeTupleStruct, SerializeTupleVariant,
};
use serde::{Serialize, Serializer};
use serde_json::Error;

/// Looks at every number that a value would write, and writes none.
#[derive(Clone, Copy)]
pub(super) struct Finite;

macro_rules! pass {
    ($($name:ident($($type:ty),*);)*) => {$(
        fn $name(self, $(_: $type),*) -> Result<(), Error> {
            Ok(())
        }
    )*};
}

macro_rules! open {
    ($($kind:ident $name:ident($($type:ty),*);)*) => {
        $(type $kind = Self;)*
        $(fn $name(self, $(_: $type),*) -> Result<Self, Error> {
            Ok(self)
        })*
    };
}

impl Serializer for Finite {
    type Ok = ();
    type Error = Error;

    fn serialize_f64(self, value: f64) -> Result<(), Error> {
        let error = || Error::custom(format!("a result is {value}, must be finite"));
        value.is_finite().then_some(()).ok_or_else(error)
    }

    fn serialize_f32(self, value: f32) -> Result<(), Error> {
        self.serialize_f64(value.into())
    }

    fn serialize_some<T: ?Sized + Serialize>(self, value: &T) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), Error> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: ?Sized + Serialize>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), Error> {
        value.serialize(self)
    }

    pass! {
        serialize_bool(bool);
        serialize_i8(i8);
        serialize_i16(i16);
        serialize_i32(i32);
        serialize_i64(i64);
        serialize_u8(u8);
        serialize_u16(u16);
        serialize_u32(u32);
        serialize_u64(u64);
        serialize_char(char);
        serialize_str(&str);
        serialize_bytes(&[u8]);
        serialize_none();
        serialize_unit();
        serialize_unit_struct(&'static str);
        serialize_unit_variant(&'static str, u32, &'static str);
    }

    open! {
        SerializeSeq serialize_seq(Option<usize>);
        SerializeTuple serialize_tuple(usize);
        SerializeTupleStruct serialize_tuple_struct(&'static str, usize);
        SerializeTupleVariant serialize_tuple_variant(&'static str, u32, &'static str, usize);
        SerializeMap serialize_map(Option<usize>);
        SerializeStruct serialize_struct(&'static str, usize);
        SerializeStructVariant serialize_struct_variant(&'static str, u32, &'static str, usize);
    }
}

macro_rules! parts {
    ($($kind:ident $($name:ident($($key:ty)?))*;)*) => {$(
        impl $kind for Finite {
            type Ok = ();
            type Error = Error;

            $(fn $name<T: ?Sized + Serialize>(
                &mut self,
                $(_: $key,)?
                value: &T,
            ) -> Result<(), Error> {
                value.serialize(*self)
            })*

            fn end(self) -> Result<(), Error> {
                Ok(())
            }
        }
    )*};
}

parts! {
    SerializeSeq serialize_element();
    SerializeTuple serialize_element();
    SerializeTupleStruct serialize_field();
    SerializeTupleVariant serialize_field();
    SerializeMap serialize_key() serialize_value();
    SerializeStruct serialize_field(&'static str);
    SerializeStructVariant serialize_field(&'static str);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_refused_wherever_it_stands() {
        #[derive(Serialize)]
        struct Held {
            values: Vec<Option<(u8, f64)>>,
        }
        let seen = |number| Held { values: vec![None, Some((1, number))] }.serialize(Finite);
        assert!(seen(1e308).is_ok());
        for number in [f64::NAN, f64::INFINITY] {
            let error = seen(number).unwrap_err().to_string();
            assert_eq!(error, format!("a result is {number}, must be finite"));
        }
    }
}
