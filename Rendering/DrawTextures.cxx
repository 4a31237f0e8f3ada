// SPDX-License-Identifier: BSD-3-Clause
#include "DrawTextures.h"

#include "OpenGLFunctions.h"

namespace isosurface
{
namespace
{

GLint GetProperty(GLenum attachment, GLenum property)
{
  GLint value = 0;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachment, property, &value);
  return value;
}

// The texture that is attached to the framebuffer; 0 if there is none.
GLuint GetTexture(GLenum attachment)
{
  return GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) == GL_TEXTURE
    ? static_cast<GLuint>(GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME))
    : 0;
}

bool HasPlainColors(GLenum attachment)
{
  return GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE) == 8 &&
    GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_ALPHA_SIZE) == 8 &&
    GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE) == GL_UNSIGNED_NORMALIZED &&
    GetProperty(attachment, GL_FRAMEBUFFER_ATTACHMENT_COLOR_ENCODING) == GL_LINEAR;
}

} // namespace

DrawTextures::DrawTextures()
{
  GLint framebuffer = 0;
  GLint target = GL_NONE;
  GLint samples = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
  glGetIntegerv(GL_DRAW_BUFFER, &target);
  glGetIntegerv(GL_SAMPLES, &samples);
  if (!ISOSURFACE_HAS_OPENGL(ARB_clear_texture) ||
    !ISOSURFACE_HAS_OPENGL(ARB_direct_state_access) || framebuffer == 0 || target == GL_NONE ||
    samples != 0 || GetTexture(GL_STENCIL_ATTACHMENT) != 0)
  {
    return;
  }
  this->Color = GetTexture(static_cast<GLenum>(target));
  this->Depth = GetTexture(GL_DEPTH_ATTACHMENT);
  this->IsPlain = this->Color != 0 && HasPlainColors(static_cast<GLenum>(target));
}

void DrawTextures::ClearColors(const PixelRectangle& rectangle, std::uint32_t color) const
{
  if (!rectangle.IsEmpty())
  {
    glClearTexSubImage(this->Color, 0, rectangle.X, rectangle.Y, 0, rectangle.Width,
      rectangle.Height, 1, GL_RGBA, GL_UNSIGNED_BYTE, &color);
  }
}

void DrawTextures::ClearDepths(const PixelRectangle& rectangle) const
{
  const float farthest = 1.0F;
  if (!rectangle.IsEmpty())
  {
    glClearTexSubImage(this->Depth, 0, rectangle.X, rectangle.Y, 0, rectangle.Width,
      rectangle.Height, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &farthest);
  }
}

void DrawTextures::PutColors(const PixelRectangle& rectangle, const std::uint32_t* colors) const
{
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage2D(this->Color, 0, rectangle.X, rectangle.Y, rectangle.Width, rectangle.Height,
    GL_RGBA, GL_UNSIGNED_BYTE, colors);
}

} // namespace isosurface
