"""The command ``lpcompare``: one file per sub-command, each with one function ``command``."""

from __future__ import annotations

import gc
import os
import sys
import warnings
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from pkgutil import iter_modules
from typing import Annotated

import typer

from lpcompare.cli._say import complain, say
from lpcompare.errors import LpcompareError

EXIT_BAD_INPUT = 2
_NO_MEMORY = "The work needs more memory than there is; give a smaller cloud, or --memory and --tiles."
EXAMPLES = """Begin with: lpcompare run --model bunny

Thin a file: lpcompare simplify scan.laz thin.laz --reduction 0.9

All about one command: lpcompare COMMAND --help"""


def build_app(first_word: str = "") -> typer.Typer:
    """The application with a sub-command for every file of this folder, or for the one that a word names alone.

    A command so starts without the imports of the others.
    """
    app = typer.Typer(
        help="Thin point clouds by boolean linear programming, and compare methods at equal counts.",
        epilog=EXAMPLES,
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_root)
    commands = sorted(m.name for m in iter_modules(__path__) if not m.name.startswith("_"))
    for name in [first_word] if first_word in commands else commands:
        app.command(name)(import_module(f"{__name__}.{name}").command)
    return app


def _print_version(asked: bool) -> None:
    if asked:
        from lpcompare import __version__

        say(f"lpcompare {__version__}")
        raise typer.Exit


def _root(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version.")
    ] = False,
) -> None:
    """Hold the options of the whole command."""


def main() -> None:
    """Run ``lpcompare``; what is wrong with the input is one sentence on stderr and exit code 2."""
    _open_streams()
    warnings.showwarning = lambda message, *_, **__: complain(str(message))
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error does, in any encoding
    try:
        build_app("".join(sys.argv[1:2]))(prog_name="lpcompare")
    except LpcompareError as error:
        _quit(str(error))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except MemoryError:
        _quit(_NO_MEMORY)
    except RuntimeError as error:
        if "start new thread" not in str(error):  # Python's words where the system gives no memory for one
            raise
        _quit(_NO_MEMORY)
    except OSError as error:
        _quit(f"{error.filename or 'The system'}: {error.strerror or error}.")
    finally:
        gc.freeze()  # the interpreter's last search for garbage takes half a second and frees nothing that matters


def _open_streams() -> None:
    """Give each standard stream that was closed the null device, so that no file takes its number."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            with suppress(OSError):
                os.close(number)
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
            setattr(sys, name, open(number, "w" if number else "r", encoding="utf-8", closefd=False))  # noqa: SIM115


def _quit(sentence: str) -> None:
    complain(sentence)
    sys.exit(EXIT_BAD_INPUT)
