"""Closed-form references in expected.toml: arithmetic, pi and the functions of `math`, in named variables. No Python."""

import ast
import math
import operator

from tern.errors import ReductionError

_BINARY = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
           ast.Pow: operator.pow}
_UNARY = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_FUNCTIONS = {name: getattr(math, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh",
                                                      "atan", "fabs")} | {"min": min, "max": max}
_CONSTANTS = {"pi": math.pi, "e": math.e}


def compile_expression(text):
    """A function of a dict of variables, e.g. {"t": 0.1}; `^` is a power, as in case files."""
    try:
        tree = ast.parse(text.replace("^", "**"), mode="eval").body
    except SyntaxError as error:
        raise ReductionError(f"the expression {text!r} cannot be read ({error.msg})") from error

    def evaluate(node, variables):
        match node:
            case ast.Constant(value=int() | float() as value):
                return value
            case ast.Name(id=name) if name in variables or name in _CONSTANTS:
                return variables.get(name, _CONSTANTS.get(name))
            case ast.BinOp() if type(node.op) in _BINARY:
                return _BINARY[type(node.op)](evaluate(node.left, variables), evaluate(node.right, variables))
            case ast.UnaryOp() if type(node.op) in _UNARY:
                return _UNARY[type(node.op)](evaluate(node.operand, variables))
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in _FUNCTIONS:
                return _FUNCTIONS[name](*(evaluate(argument, variables) for argument in node.args))
        raise ReductionError(f"the expression {text!r} uses {ast.unparse(node)!r}, which is not arithmetic in "
                             f"{', '.join(variables)}")

    return lambda variables: evaluate(tree, variables)
