"""Compile a function that compiled code calls once, as a part of its callers.

By itself, numba optimises a function together with everything that it calls, makes machine code of
it and a door for Python, and does so again at each level of a tree of calls. Only the outermost
function of a tree needs that. So a `Function` has two forms. Python calls the outer form. Compiled
code calls the inner form, which stays as it was lowered; the caller is optimised together with it.

All CPU time of the first `izo demo` fell from 67 to 46 s by that. Steps take as long as before, or
up to 3 % less. The order of optimisations does not change a bit of a result, because LLVM neither
re-orders nor contracts operations on floats if it is not allowed to.
"""

import gc
import mmap
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from numba.core import config, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import FunctionPass, PassManager, register_pass
from numba.core.registry import CPUDispatcher
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.core.typed_passes import NopythonTypeInference

from izo_ref.base.kept_code import CodeFiles, Place

# A compiler makes many objects and keeps most of them until it ends, so searching for garbage in
# between is in vain. With the default threshold of 700 new objects a search, the searches take an
# eighth of the compile time. This many times the threshold takes 20 MB more memory.
RARELY = 100
# Address space that LLVM may need for one function [bytes]. Loading fails below 24 MiB; the first
# function that is compiled takes 147 MiB with what numba loads for it, and the others up to 53.
LOADING, COMPILING = 32 << 20, 256 << 20
# Some functions import scipy.linalg while they are loaded, whose BLAS waits for ever if it gets no
# memory. It takes 120 MiB on 2 cores, and has threads and buffers for each core.
BLAS = (128 << 20) + (os.cpu_count() or 1) * (32 << 20)


@contextmanager
def setting(config: Any, name: str, value: Any) -> Iterator[None]:
    """Change a setting of numba while a block runs.

    Args:
        config: `numba.core.config`, or that of numba-cuda.
        name: The setting.
        value: Its value in the block.
    """
    before = getattr(config, name)
    setattr(config, name, value)
    try:
        yield
    finally:
        setattr(config, name, before)


class _NoEnvironment:
    """Stands for the code generator of a function that has no machine code of its own."""

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: there is no machine code that could look for its environment."""


class _InnerLibrary(JITCodeLibrary):
    """Code of an inner form: it is linked into the callers, and never becomes machine code."""

    @property
    def codegen(self) -> Any:
        """Return what numba tells about the environment of the function."""
        return _NoEnvironment()

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, which stands for a function that Python cannot call."""
        return 0


@register_pass(mutates_CFG=False, analysis_only=False)
class _TakeInnerLibrary(FunctionPass):
    """Give a function an `_InnerLibrary`, into which it will be lowered."""

    _name = "take_inner_library"

    def __init__(self) -> None:
        """Make the pass; numba asks for a constructor."""
        super().__init__()

    def run_pass(self, state: Any) -> Any:
        """Set the library, which numba would make itself if there were none."""
        state.library = _InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return True


class _InnerCompiler(CompilerBase):
    """Compiles the inner form of a function."""

    def define_pipelines(self) -> list[PassManager]:
        """Return numba's usual passes, and the one above."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_TakeInnerLibrary, NopythonTypeInference)
        passes.finalize()
        return [passes]


class _CacheImpl(CompileResultCacheImpl):
    """What numba does to keep code on the disk, with a folder of ours."""

    def __init__(self, function: Any, folder: Path) -> None:
        """Take this folder alone, whatever numba's variables of the environment say."""
        self._locator_classes = [Place(folder)]
        with setting(config, "CACHE_LOCATOR_CLASSES", ""):
            super().__init__(function)


class _Cache(FunctionCache):
    """Compiled code on the disk that is loaded without all that compiling needs.

    Args:
        function: The function.
        folder: Folder of all compiled code.
    """

    def __init__(self, function: Any, folder: Path) -> None:
        """Read nothing yet."""
        self._impl_class = partial(_CacheImpl, folder=folder)
        super().__init__(function)
        impl = self._impl
        stamp = impl.locator.get_source_stamp()
        self._cache_file = CodeFiles(self.cache_path, impl.filename_base, stamp, dumps)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the code of a signature, or return None.

        numba first declares all functions that it can compile, which takes a third of the time of a
        call of `izo` with compiled code. Loading needs numba's management of memory alone, and a
        compiler declares the functions itself.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            code = self._load_overload(sig, target_context)
        if code is None:
            require_room(COMPILING)
        return code


def require_room(n_bytes: int) -> None:
    """Check that the process can still have some memory, and give it back.

    LLVM ends the process by a signal where it gets no memory, and Python cannot say why. So we ask
    for memory before LLVM does. It is reserved and not touched, which takes 10 us.

    Args:
        n_bytes: How much.

    Raises:
        MemoryError: The process can have less.
    """
    try:
        mmap.mmap(-1, n_bytes).close()
    except OSError:
        raise MemoryError(
            f"compiled code needs {n_bytes >> 20} MiB of address space to be loaded or made, and "
            "the process can have less"
        ) from None


class Function(CPUDispatcher):
    """A compiled function; compiled code that calls it calls its inner form.

    Attributes:
        prepare: Function that is called with this one before it is compiled or loaded for the first
            time, or None.
    """

    prepare: Callable[[Any], None] | None = None

    def compile(self, sig: Any) -> Any:
        """Compile the function for a signature, or load it, with few searches for garbage."""
        with global_compiler_lock:  # so that one thread at a time changes what is changed here
            if self.prepare is not None:
                self.prepare(self)
                self.prepare = None
            require_room(COMPILING if isinstance(self._cache, NullCache) else LOADING)
            if "scipy.linalg" not in sys.modules:
                require_room(BLAS)
            threshold = gc.get_threshold()
            gc.set_threshold(RARELY * threshold[0], *threshold[1:])
            try:
                return super().compile(sig)
            finally:
                gc.set_threshold(*threshold)

    def keep_in(self, folder: Path) -> None:
        """Keep compiled code on the disk, in a folder of this folder."""
        if Path(self.py_func.__code__.co_filename).is_file():  # else nothing says if it is stale
            self._cache = _Cache(self.py_func, folder)

    @property
    def _numba_type_(self) -> types.Dispatcher:
        return self.inner._numba_type_

    @cached_property
    def inner(self) -> CPUDispatcher:
        """The inner form."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        return CPUDispatcher(self.py_func, self.locals, options, pipeline_class=_InnerCompiler)
