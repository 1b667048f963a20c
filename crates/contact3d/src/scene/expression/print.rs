//! Formulas as text, with no more parentheses than their meaning takes.

use super::program::{Binary, Instruction, SMOOTH};

/// How tightly the outermost operator of a text binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Power,
    Operand,
}

/// A text that reads back to the steps of a formula.
pub(super) fn text(steps: &[Instruction], variables: &[&str], parameters: &[String]) -> String {
    let mut stack: Vec<(String, Binding)> = Vec::new();
    for step in steps {
        let mut taken = || stack.pop().expect("a step has its arguments");
        let printed = match *step {
            Instruction::Number(value) if value < 0.0 => (format!("({value:?})"), Binding::Operand),
            Instruction::Number(value) => (format!("{value:?}"), Binding::Operand),
            Instruction::Variable(place) => (variables[place].to_owned(), Binding::Operand),
            Instruction::Parameter(place) => (parameters[place].clone(), Binding::Operand),
            Instruction::Smooth(place) => {
                let (name, ..) = SMOOTH[place];
                (format!("{name}({})", taken().0), Binding::Operand)
            }
            Instruction::Abs => (format!("abs({})", taken().0), Binding::Operand),
            Instruction::Binary(binary) => {
                let right = taken();
                between(binary, taken(), right)
            }
            Instruction::Choose(comparison) => {
                let [second, first, right, left] = std::array::from_fn(|_| taken().0);
                let sign = comparison.sign();
                let text = format!("if({left} {sign} {right}, {first}, {second})");
                (text, Binding::Operand)
            }
        };
        stack.push(printed);
    }
    stack.pop().map_or_else(String::new, |(text, _)| text)
}

/// An operator between its arguments, or a function of them.
fn between(
    binary: Binary,
    (left, left_binds): (String, Binding),
    (right, right_binds): (String, Binding),
) -> (String, Binding) {
    let (sign, binds) = match binary {
        Binary::Add => (" + ", Binding::Sum),
        Binary::Subtract => (" - ", Binding::Sum),
        Binary::Multiply => ("*", Binding::Product),
        Binary::Divide => ("/", Binding::Product),
        Binary::Power => ("^", Binding::Power),
        Binary::Min => return (format!("min({left}, {right})"), Binding::Operand),
        Binary::Max => return (format!("max({left}, {right})"), Binding::Operand),
    };
    // Operators of one precedence go from left to right, and powers of powers do not stand alone.
    let left_bare = left_binds >= binds && binds != Binding::Power;
    let left = in_parentheses(left, left_bare || left_binds == Binding::Operand);
    let right = in_parentheses(right, right_binds > binds);
    (format!("{left}{sign}{right}"), binds)
}

fn in_parentheses(text: String, is_bare: bool) -> String {
    if is_bare { text } else { format!("({text})") }
}
