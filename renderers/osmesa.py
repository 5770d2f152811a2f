"""A pyrender renderer on OSMesa that draws our own shaders into one float target."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from renderers.errors import RendererError

if TYPE_CHECKING:
    import pyrender

SHADERS = Path(__file__).parent / "shaders"


def import_pyrender() -> Any:
    """Import pyrender for OSMesa.

    Raises
    ------
    RendererError
        If OSMesa's library or pyrender cannot be loaded.
    """
    os.environ["PYOPENGL_PLATFORM"] = "osmesa"  # PyOpenGL reads it at its first import
    try:
        import OpenGL

        OpenGL.ERROR_CHECKING = False  # halves the cost of each call
        import pyrender
    except Exception as error:  # PyOpenGL raises AttributeError, ImportError or OSError, as it likes
        raise RendererError(
            f"engine 'rasterise': OSMesa cannot be loaded ({error}); "
            "install libosmesa6 or use --engine raycast"
        ) from error
    return pyrender


class FloatTarget:
    """An OSMesa context with one RGBA32F colour target of a fixed size.

    Draws the meshes of a pyrender scene with ``renderers/shaders`` and reads the target back unclamped.
    """

    def __init__(self, width: int, height: int) -> None:
        pyrender = import_pyrender()
        from pyrender.platforms.osmesa import OSMesaPlatform

        self._flags = pyrender.RenderFlags.OFFSCREEN | pyrender.RenderFlags.SKIP_CULL_FACES
        self._platform = OSMesaPlatform(width, height)
        try:
            self._platform.init_context()
            self._platform.make_current()
        except Exception as error:
            raise RendererError(
                f"engine 'rasterise': no OSMesa context ({error}); install libosmesa6 or use --engine raycast"
            ) from error
        self._renderer = _float_renderer_class()(width, height)

    def draw(self, scene: pyrender.Scene) -> NDArray[np.float32]:
        """Draw and read back (H, W, 4) float32, first row on top."""
        self._platform.make_current()
        return np.asarray(self._renderer.render(scene, self._flags))

    @property
    def version(self) -> str:
        """The OpenGL version and driver of the context."""
        from OpenGL import GL

        self._platform.make_current()
        return str(GL.glGetString(GL.GL_VERSION).decode())

    def close(self) -> None:
        """Free the GL objects and the context."""
        self._platform.make_current()
        self._renderer.delete()
        self._platform.delete_context()


def _float_renderer_class() -> type:
    """The subclass can only be made once pyrender may be imported."""
    from OpenGL import GL
    from pyrender.renderer import Renderer
    from pyrender.shader_program import ShaderProgramCache

    class FloatRenderer(Renderer):  # type: ignore[misc]
        """Replaces pyrender's 8-bit, multisampled, gamma-encoded target and its shaders."""

        def __init__(self, width: int, height: int) -> None:
            self._main_fb: Any = None
            super().__init__(width, height)
            self._program_cache = ShaderProgramCache(shader_dir=str(SHADERS))

        def _bind_lighting(self, *_: object) -> None:
            """Light is computed from the G-buffer, not by the shader."""

        def _configure_main_framebuffer(self) -> None:
            if self._main_fb is not None:
                return
            size = (self.viewport_width, self.viewport_height)
            self._main_cb, self._main_db = GL.glGenRenderbuffers(2)
            self._main_fb = self._main_fb_ms = GL.glGenFramebuffers(1)
            GL.glBindFramebuffer(GL.GL_FRAMEBUFFER, self._main_fb)
            for buffer, storage, attachment in (
                (self._main_cb, GL.GL_RGBA32F, GL.GL_COLOR_ATTACHMENT0),
                (self._main_db, GL.GL_DEPTH_COMPONENT32F, GL.GL_DEPTH_ATTACHMENT),
            ):
                GL.glBindRenderbuffer(GL.GL_RENDERBUFFER, buffer)
                GL.glRenderbufferStorage(GL.GL_RENDERBUFFER, storage, *size)
                GL.glFramebufferRenderbuffer(GL.GL_FRAMEBUFFER, attachment, GL.GL_RENDERBUFFER, buffer)

        def _delete_main_framebuffer(self) -> None:
            if self._main_fb is not None:
                GL.glDeleteFramebuffers(1, [self._main_fb])
                GL.glDeleteRenderbuffers(2, [self._main_cb, self._main_db])
            self._main_fb = self._main_fb_ms = self._main_cb = self._main_db = None

        def _read_main_framebuffer(self, scene: object, flags: int) -> NDArray[np.float32]:
            width, height = self.viewport_width, self.viewport_height
            GL.glBindFramebuffer(GL.GL_READ_FRAMEBUFFER, self._main_fb)
            pixels = GL.glReadPixels(0, 0, width, height, GL.GL_RGBA, GL.GL_FLOAT)
            return np.frombuffer(pixels, dtype=np.float32).reshape(height, width, 4)[::-1]

    return FloatRenderer
