"""The one way to start a study.

    python -m experiments                           # the list of them
    python -m experiments NAME [WORD ...]           # misuse, structure.routes: what the study's own page says
    python -m experiments NAME --small              # in minutes, its tables in a folder of their own

A study is a module (or the ``__main__`` of a folder) with a ``main()`` that reads its words as any command does. What
`--small` stands for is its ``IN_MINUTES``, where ``{}`` is an empty folder; a study without has an option of that
name, or takes minutes as it is. Belongs here: finding and starting. Does not belong here: any study.
"""

from __future__ import annotations

import ast
import importlib
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent


def studies() -> dict[str, str]:
    """Name of every study and the first line of what it says of itself; nothing of it is imported."""
    found = {}
    for path in sorted(HERE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if path.parent != HERE and any(isinstance(one, ast.FunctionDef) and one.name == "main" for one in tree.body):
            name = ".".join(path.relative_to(HERE).with_suffix("").parts).removesuffix(".__main__")
            found[name] = (ast.get_docstring(tree) or "").partition("\n")[0]
    return found


def main() -> int:
    """Start the study of that name; 2 with the list where there is none."""
    name, *words = sys.argv[1:] or [""]
    known = studies()
    if name not in known:
        print("\n".join(f"{one:32} {said}" for one, said in known.items()), file=sys.stderr)
        return 2
    folder = HERE.joinpath(*name.split("."))
    study = importlib.import_module(f"experiments.{name}{'.__main__' if folder.is_dir() else ''}")
    if "--small" in words and hasattr(study, "IN_MINUTES"):
        scratch = tempfile.mkdtemp(prefix="small_")
        words = [word.replace("{}", scratch) for word in study.IN_MINUTES.split()]
        print(f"experiments {name} {' '.join(words)}", flush=True)
    sys.argv = [f"experiments {name}", *words]
    return study.main() or 0


if __name__ == "__main__":
    sys.exit(main())
