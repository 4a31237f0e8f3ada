// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_OpenGLFunctions_h
#define isosurface_OpenGLFunctions_h

// OpenGL's functions and extensions, as the VTK that is built with loads them: by glad since 9.4, by
// GLEW before.
#if __has_include("vtk_glad.h")
#  include "vtk_glad.h"
#  define ISOSURFACE_HAS_OPENGL(extension) (GLAD_GL_##extension != 0)
#else
#  include "vtk_glew.h"
#  define ISOSURFACE_HAS_OPENGL(extension) (GLEW_##extension != 0)
#endif

#endif
