//! ELF images for tests.

use object::write::{Object, Symbol, SymbolSection};
use object::{
    Architecture, BinaryFormat, Endianness, SectionKind, SymbolFlags, SymbolKind, SymbolScope,
};

/// Name, address and size in bytes of a symbol.
pub type Place<'a> = (&'a str, u64, u64);

/// Makes an image with `sections` and `symbols`.
pub fn image(sections: &[(&str, Vec<u8>)], symbols: &[Place<'_>]) -> Vec<u8> {
    let mut object = Object::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
    for (name, content) in sections {
        let section = object.add_section(Vec::new(), name.bytes().collect(), SectionKind::Text);
        object.append_section_data(section, content, 4);
    }
    for (name, value, size) in symbols {
        object.add_symbol(Symbol {
            name: name.bytes().collect(),
            value: *value,
            size: *size,
            kind: SymbolKind::Text,
            scope: SymbolScope::Linkage,
            weak: false,
            section: SymbolSection::Absolute,
            flags: SymbolFlags::None,
        });
    }
    object.write().expect("an ELF file")
}
