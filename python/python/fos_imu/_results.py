"""Results as the engine hands them over, JSON, made into frozen dataclasses by their annotations."""

from __future__ import annotations

import dataclasses
import functools
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

T = TypeVar("T")
Make = Callable[[Any], Any]


def build(kind: type[T], data: Mapping[str, Any]) -> T:
    """The dataclass `kind` of the keys of `data` that it has fields for; what is absent has its default."""
    values = {name: make(data[name]) for name, make in _makers(kind) if name in data}
    return kind(**values)


@functools.cache
def _makers(kind: type[Any]) -> tuple[tuple[str, Make], ...]:
    hints = typing.get_type_hints(kind)
    return tuple((field.name, _maker(hints[field.name])) for field in dataclasses.fields(kind))


def _maker(hint: Any) -> Make:  # noqa: ANN401
    origin = typing.get_origin(hint)
    arguments = typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        inner = _maker(next(argument for argument in arguments if argument is not type(None)))
        return lambda value: None if value is None else inner(value)
    if origin is tuple:
        makers = [_maker(argument) for argument in arguments if argument is not ...]
        if len(arguments) == 2 and arguments[1] is ...:
            return lambda value: tuple(makers[0](item) for item in value)
        return lambda value: tuple(make(item) for make, item in zip(makers, value, strict=True))
    if origin in (dict, Mapping):
        make = _maker(arguments[1])
        return lambda value: types.MappingProxyType({key: make(item) for key, item in value.items()})
    if hint is float:
        # in JSON what is not finite is null
        return lambda value: float("nan") if value is None else float(value)
    if dataclasses.is_dataclass(hint):
        return functools.partial(build, typing.cast("type[Any]", hint))
    return lambda value: value
