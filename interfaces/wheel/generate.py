"""Generate the sources of ROS packages for rclpy on Fast DDS: ``generate.py OUTPUT PACKAGE...``.

ROS's own generators write the files, for C, Python and the two type supports that Fast DDS uses.
``rosidl_generate_interfaces`` starts each generator once for each package; each start parses each
interface and scans each template again for each message. Here, one process does all of a package,
and parses and scans each text once: a tenth of the processor time.

Below OUTPUT are the sources, and ``python`` and ``share`` as they are installed. The order of
includes follows from Python's hashes: with a fixed ``PYTHONHASHSEED`` the same input gives the same
bytes.
"""

from __future__ import annotations

import builtins
import functools
import json
import multiprocessing
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType
from typing import Any

import em
import rosidl_parser.parser
from rosidl_adapter import convert_to_idl
from rosidl_generator_c import generate_c
from rosidl_generator_py import generate_py
from rosidl_generator_type_description import generate_type_hash
from rosidl_typesupport_c import generate_c as generate_type_support
from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c
from rosidl_typesupport_introspection_c import generate_c as generate_introspection_c

ROS = Path(rosidl_parser.__file__).parents[4]
"""The prefix of the ROS wheels, four levels above any of their modules."""

SHARE = ROS / "share"
COMMENT = re.compile(r'@verbatim \(language="comment", text=\s*(?:"(?:[^"\\]|\\.)*"\s*)+\)')
KINDS = ("msg", "srv", "action")
TYPE_SUPPORTS = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]


@functools.cache
def scanned(template: str) -> list[Any]:
    """Return the tokens of a template of EmPy 3."""
    scanner = em.Scanner("@", template)
    return list(iter(scanner.one, None))


@functools.cache
def compiled(source: str, mode: str) -> CodeType:
    """Return the code of a template's expression (``eval``) or statements (``exec``)."""
    return compile(source.strip() if mode == "eval" else source, "<template>", mode)


def expand(interpreter: em.Interpreter, scanner: em.Scanner, _final: bool, names: Any) -> None:  # noqa: FBT001
    """Stand in for EmPy's ``Interpreter.safe``, which scans a template each time it is expanded."""
    for token in scanned(scanner.buffer):
        token.run(interpreter, names)


def parsed(interface: str, parse: Any = rosidl_parser.parser.get_ast_from_idl_string) -> Any:
    """Return the syntax tree of an interface, without its comments: three quarters of the work."""
    return parse(COMMENT.sub("", interface))


def remember() -> None:
    """Have the generators scan, compile and parse each text once."""
    em.Interpreter.safe = expand
    em.eval = lambda source, *names: builtins.eval(compiled(source, "eval"), *names)  # noqa: S307
    em._exec = lambda source, *names: exec(compiled(source, "exec"), *names)  # noqa: S102, SLF001
    rosidl_parser.parser.get_ast_from_idl_string = functools.cache(parsed)


def generate(folder: Path, output: Path) -> None:
    """Generate the sources of one package."""
    package = folder.name
    share, types, c, fastrtps, introspection, rclpy, python = (
        output / part / package
        for part in ("share", "types", "c", "fastrtps", "introspection", "rclpy", "python")
    )
    interfaces = [file for kind in KINDS for file in sorted((folder / kind).glob("*.*"))]
    for file in interfaces:
        convert_to_idl(folder, package, file.relative_to(folder), share)
        shutil.copy(file, share / file.parent.name)
    shutil.copy(folder / "package.xml", share)
    index = output / "share/ament_index/resource_index"
    parts = [f"{file.parent.name}/{file.stem}" for file in interfaces]
    sources = [f"{file.parent.name}/{file.name}" for file in interfaces]
    listed = sorted([*sources, *(f"{part}.idl" for part in parts)])
    write(index / "packages" / package, "")
    write(index / "rosidl_interfaces" / package, "\n".join(listed))

    def run(generator: Callable[..., Any], module: str, place: Path, *arguments: Any) -> None:
        given = {
            "package_name": package,
            "output_dir": str(place),
            "template_dir": str(SHARE / module / "resource"),
            "idl_tuples": [f"{share}:{part}.idl" for part in parts],
            "ros_interface_files": [str(file) for file in interfaces],
            "target_dependencies": [],
        }
        if generator is generate_type_hash:
            given["include_paths"] = [f"{path.name}:{path}" for path in SHARE.iterdir()]
        if generator is generate_c:
            given["type_description_tuples"] = [f"{part}.idl:{types / part}.json" for part in parts]
        written = output / f"{package}.{module}.json"
        write(written, json.dumps(given))
        generator(str(written), *arguments)

    run(generate_type_hash, "rosidl_generator_type_description", types)
    for part in parts:
        shutil.copy(types / f"{part}.json", share / Path(part).parent)
    run(generate_c, "rosidl_generator_c", c)
    run(generate_typesupport_fastrtps_c, "rosidl_typesupport_fastrtps_c", fastrtps)
    run(generate_introspection_c, "rosidl_typesupport_introspection_c", introspection)
    run(generate_type_support, "rosidl_typesupport_c", rclpy, TYPE_SUPPORTS)
    run(generate_py, "rosidl_generator_py", python, ["rosidl_typesupport_c"])
    write(python / "__init__.py", "")
    for module in ("rosidl_generator_c", *TYPE_SUPPORTS):
        header = f"{module}__visibility_control.h"
        text = (SHARE / module / "resource" / f"{header}.in").read_text(encoding="utf-8")
        text = text.replace("@PROJECT_NAME@", package)
        write(c / "msg" / header, text.replace("@PROJECT_NAME_UPPER@", package.upper()))


def write(path: Path, text: str) -> None:
    """Write a file, with its folders."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def main() -> None:
    """Generate all packages, as many at a time as there are processors, the largest first."""
    output, *folders = (Path(argument).resolve() for argument in sys.argv[1:])
    remember()
    sizes = {folder: sum(1 for _ in folder.glob("*/*.*")) for folder in folders}
    largest_first = sorted(folders, key=sizes.__getitem__, reverse=True)
    with multiprocessing.Pool(min(len(folders), os.cpu_count() or 1)) as pool:
        pool.starmap(generate, [(folder, output) for folder in largest_first], chunksize=1)


if __name__ == "__main__":
    main()
