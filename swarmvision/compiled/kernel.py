"""A kernel: optimised once, together with everything that it calls, where Python calls it.

numba optimises every function as soon as it is called from another, generates its machine code and a door
for Python, and does so again inside each caller, and once more for each constant that is handed over. Here a
kernel that a kernel calls is a *part*: typed, not optimised, nowhere but in memory. What Python calls is a
*whole*: it takes in its parts and the parts of its parts, is optimised and kept on disk. A large
kernel compiles in less than half the time, and the code has the same steps in the same order.
"""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import codegen, compiler, event, sigutils, typed_passes, typing, untyped_passes
from numba.core import types as _types
from numba.core.caching import FunctionCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.registry import CPUDispatcher
from numba.core.runtime import rtsys
from numpy import ndarray

types: Any = _types  # its names come by star
NEEDLESS = (untyped_passes.InlineClosureLikes, typed_passes.NopythonRewrites)
"""Passes for functions inside functions and arithmetic on whole arrays; kernels are loops over numbers."""
FLAGS_HASH = hash(tuple(sorted(compiler.Flags.options)))
"""Of all flags, whatever is set; what numba takes anew at every question."""


class Kernel(CPUDispatcher):  # type: ignore[misc]  # numba is untyped
    """Compiles wholes as numba does, by our compiler, and hands parts to other kernels."""

    def __init__(
        self,
        py_func: Any,
        locals: Any = None,
        targetoptions: Any = None,
        *,
        apart: bool = False,
        attributes: Iterable[str] = (),
    ) -> None:
        super().__init__(py_func, locals, targetoptions)
        self._compiler = _Compiler(py_func, self.targetdescr, self.targetoptions, self.locals, _Pipeline)
        self._compiler.apart, self._compiler.attributes = apart, tuple(attributes)
        self._parts: dict[Any, tuple[Any, object]] = {}
        """Signature and the target's name of each part, by the types of its arguments."""

    def enable_caching(self) -> None:
        """Keep what is compiled on disk."""
        self._cache = _Kept(self.py_func)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Tell a kernel that is being typed what calling this one means; constants are values."""
        pysig, args = self._compiler.fold_argument_types(args, kws)
        args = tuple(types.unliteral(each) for each in args)
        with global_compiler_lock, self._compiling_counter:
            if args not in self._parts:
                self._parts[args] = self._part(args)
        name = self.py_func.__name__
        signatures = [signature for signature, _ in self._parts.values()]
        return typing.make_concrete_template(name, key=name, signatures=signatures), pysig, args, {}

    def get_overload(self, sig: Any) -> object:
        """Return the name by which the target knows a part."""
        args, _ = sigutils.normalize_signature(sig)
        return self._parts[tuple(args)][1]

    def _part(self, args: tuple[Any, ...]) -> tuple[Any, object]:
        details = {"dispatcher": self, "args": args, "return_type": None}
        with event.trigger_event("numba:compile", data=details):
            part = self._compiler.compile_part(args)
        name = object()
        self.targetctx.insert_user_function(name, part.fndesc, [part.library])
        return part.signature, name


class _Pipeline(compiler.CompilerBase):  # type: ignore[misc]
    """numba's passes without those for what no kernel has: a twelfth of the time."""

    def define_pipelines(self) -> list[Any]:
        """Return the one list of passes (numba's own hook)."""
        passes = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [each for each in passes.passes if each[0] not in NEEDLESS]
        passes.finalize()
        return [passes]


class Door:
    """The way from Python into a whole that knows named tuples by their class.

    numba asks every argument for its type at every call, and of a named tuple each member: 0.1 us an array.
    """

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._ways: dict[Any, Any] = {}

    def __call__(self, *args: Any) -> Any:
        """Call the kernel."""
        kinds = tuple(
            [
                (type(each), each.ndim, each.dtype, each.flags.num)
                if isinstance(each, ndarray)
                else type(each)
                for each in args
            ]
        )
        way = self._ways.get(kinds)
        if way is None:
            if tuple in kinds:
                raise TypeError("only named tuples are known by their class")
            way = self._kernel.compile(tuple(self._kernel.typeof_pyval(each) for each in args))
            self._ways[kinds] = way
        return way(*args)


class _Kept(FunctionCache):  # type: ignore[misc]
    """What is kept on disk, fetched without what only compiling needs.

    numba imports all that it can compile, SciPy's linear algebra too, before it looks for what is kept; and
    again before it compiles.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the whole for a signature, None where none is kept (numba's own hook)."""
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():  # a file that cannot be read is none
            return self._load_overload(sig, target_context)


class _Flags(compiler.Flags):  # type: ignore[misc]
    """Flags that are compared by what is set alone: numba does so whenever it types a call."""

    def __eq__(self, other: object) -> Any:
        if isinstance(other, _Flags):
            return bool(self._values == other._values)
        return super().__eq__(other)

    def __hash__(self) -> int:
        return FLAGS_HASH


class _Compiler(_FunctionCompiler):  # type: ignore[misc]
    """Builds parts and wholes."""

    apart = False
    """Whether no two arrays that the function is handed overlap."""

    attributes: tuple[str, ...] = ()
    """Of the function, as LLVM writes them."""

    def compile_part(self, args: tuple[Any, ...]) -> Any:
        """Return a part for arguments of these types."""
        return self._build(_Part, args, None)

    def _compile_core(self, args: tuple[Any, ...], return_type: Any) -> Any:
        """Return a whole, ready to be called (numba's own hook)."""
        with _no_collection():
            result = self._build(_Whole, args, return_type)
        for environment in result._find_referenced_environments():  # its parts' too
            result.library.codegen.set_env(environment.env_name, environment)
        return result

    def _build(self, kind: type[_Part | _Whole], args: tuple[Any, ...], return_type: Any) -> Any:
        flags = _Flags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        flags.no_cfunc_wrapper, flags.noalias = True, self.apart
        flags.no_compile = flags.no_cpython_wrapper = kind is _Part
        target = self.targetdescr.target_context
        library = kind(target.codegen(), self.py_func.__qualname__)
        library.attributes = self.attributes
        if kind is _Whole:
            library.enable_object_caching()
        return compiler.compile_extra(
            self.targetdescr.typing_context,
            target,
            self.py_func,
            args,
            return_type,
            flags,
            self.locals,
            library,
            self.pipeline_class,
        )


@contextmanager
def _no_collection() -> Iterator[None]:
    """Keep the garbage as it is: while a whole is compiled hardly anything dies of the millions of objects.

    To go through them again and again takes a fifth of the time.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


class _Library(codegen.JITCodeLibrary):  # type: ignore[misc]
    """Code whose functions have attributes of LLVM's."""

    attributes: tuple[str, ...] = ()

    def add_ir_module(self, ir_module: Any) -> None:
        for function in ir_module.functions if self.attributes else ():
            if not function.is_declaration:
                set.update(function.attributes, self.attributes)  # its own way in knows no quoted ones
        super().add_ir_module(ir_module)


class _Part(_Library):
    """Code of one kernel alone, to be linked into wholes."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True


class _Whole(_Library):
    """Code of a kernel and of all its parts."""

    def finalize(self) -> None:
        self._linking_libraries: list[Any] = _with_parts(self._linking_libraries)
        super().finalize()


def _with_parts(libraries: Iterable[Any]) -> list[Any]:
    """Return libraries and those that parts among them call, each once, and callers before what they call.

    The linker takes nothing that nobody has asked for yet.
    """
    found: dict[Any, None] = {}
    ordered: list[Any] = []

    def visit(library: Any) -> None:
        if library not in found:
            found[library] = None
            for callee in library._linking_libraries if isinstance(library, _Part) else ():
                visit(callee)
            ordered.append(library)

    for library in libraries:
        visit(library)
    return ordered[::-1]
