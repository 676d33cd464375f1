"""Writes python/detune/types.pyi: the keys of the module's results, from the JSON Schemas of the command.

python tests/python/types_of_schemas.py
"""

import json
import keyword
import pathlib
import subprocess
import sys

FILE = pathlib.Path(__file__).resolve().parents[2] / "python/detune/types.pyi"
RESULTS = ("check", "advice", "identification", "diagnosis")
PLAIN = {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}
HEAD = '''"""What the results of the module hold, for type checkers alone: written by
tests/python/types_of_schemas.py from the schemas of the command. Import it under TYPE_CHECKING."""

from typing import Any, Dict, List, Literal, Union

from .results import Record
'''


class Stubs:
    """The classes of one schema."""

    def __init__(self, prefix, schema):
        self.prefix, self.definitions, self.classes = prefix, schema.get("$defs", {}), {}
        for name, definition in self.definitions.items():
            if "properties" in definition:
                self.add(prefix + name, definition)
        self.add(prefix + "Keys", schema)

    def add(self, name, schema):
        lines = [f"class {name}(Record):"]
        for key, value in schema["properties"].items():
            if not key.isidentifier() or keyword.iskeyword(key):
                continue
            camel = "".join(word.capitalize() for word in key.split("_"))
            own = (self.prefix if name.endswith("Keys") else name) + camel
            lines += ["    @property", f"    def {key}(self) -> {self.of(value, own)}: ..."]
        self.classes[name] = "\n".join(lines)
        return name

    def of(self, schema, name, is_wrapped=True):
        """A type for what a schema describes; objects in lists of lists stay plain."""
        if "$ref" in schema:
            key = schema["$ref"].rsplit("/", 1)[1]
            definition = self.definitions[key]
            if "properties" in definition and is_wrapped:
                return self.prefix + key
            return self.of(definition, name, is_wrapped)
        if "anyOf" in schema:
            return union(self.of(one, name, is_wrapped) for one in schema["anyOf"])
        if "enum" in schema:
            return "Literal[" + ", ".join(
                "None" if one is None else json.dumps(one) for one in schema["enum"]
            ) + "]"
        kinds = schema.get("type", [])
        kinds = [kinds] if isinstance(kinds, str) else kinds
        return union(self.one(kind, schema, name, is_wrapped) for kind in kinds) or "Any"

    def one(self, kind, schema, name, is_wrapped):
        if kind == "array":
            items = schema.get("items", {})
            is_list = "array" in items.get("type", [])
            return f"List[{self.of(items, name, is_wrapped and not is_list)}]"
        if kind == "object":
            if not is_wrapped:
                return "Dict[str, Any]"
            return self.add(name, schema) if schema.get("properties") else "Record"
        return PLAIN[kind]


def union(types):
    different = list(dict.fromkeys(types))
    return f"Union[{', '.join(different)}]" if len(different) > 1 else "".join(different)


def stubs(command):
    """The file; `command` gives a schema by its name."""
    parts = [HEAD]
    for result in RESULTS:
        parts += Stubs(result.capitalize(), json.loads(command(result))).classes.values()
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    def command(name):
        arguments = [sys.executable, "-m", "detune", "schema", name]
        return subprocess.run(arguments, check=True, capture_output=True).stdout

    FILE.write_text(stubs(command))
