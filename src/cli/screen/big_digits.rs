//! Numbers that can be read from the jack, two metres off: three cells wide and five high.

/// Rows of a glyph, a bit a cell, the leftmost highest.
#[rustfmt::skip]
const GLYPHS: [(char, [u8; 5]); 13] = [
    ('0', [0b111, 0b101, 0b101, 0b101, 0b111]),
    ('1', [0b010, 0b110, 0b010, 0b010, 0b111]),
    ('2', [0b111, 0b001, 0b111, 0b100, 0b111]),
    ('3', [0b111, 0b001, 0b111, 0b001, 0b111]),
    ('4', [0b101, 0b101, 0b111, 0b001, 0b001]),
    ('5', [0b111, 0b100, 0b111, 0b001, 0b111]),
    ('6', [0b111, 0b100, 0b111, 0b101, 0b111]),
    ('7', [0b111, 0b001, 0b001, 0b010, 0b010]),
    ('8', [0b111, 0b101, 0b111, 0b101, 0b111]),
    ('9', [0b111, 0b101, 0b111, 0b001, 0b111]),
    ('-', [0b000, 0b000, 0b111, 0b000, 0b000]),
    ('.', [0b000, 0b000, 0b000, 0b000, 0b010]),
    (' ', [0b000, 0b000, 0b000, 0b000, 0b000]),
];

/// Rows of a number; characters without a glyph are left blank.
pub(super) fn rows(number: &str, ink: char) -> [String; 5] {
    std::array::from_fn(|row| {
        let mut line = String::new();
        for character in number.chars() {
            let glyph = GLYPHS.iter().find(|(known, _)| *known == character);
            let bits = glyph.map_or(0, |(_, rows)| rows[row]);
            for column in (0..3).rev() {
                line.push(if bits >> column & 1 == 1 { ink } else { ' ' });
            }
            line.push(' ');
        }
        line
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_drawn_glyph_by_glyph() {
        let rows = rows("-7.1", '#');
        assert_eq!(
            rows,
            [
                "    ###      #  ",
                "      #     ##  ",
                "###   #      #  ",
                "     #       #  ",
                "     #   #  ### ",
            ]
        );
    }
}
