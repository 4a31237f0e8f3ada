// SPDX-License-Identifier: BSD-3-Clause
#include "SavedImage.h"

#include "OpenGLFunctions.h"

namespace isosurface
{
namespace
{

GLuint GetBinding(GLenum name)
{
  GLint binding = 0;
  glGetIntegerv(name, &binding);
  return static_cast<GLuint>(binding);
}

GLint GetAttachmentParameter(GLenum attachment, GLenum name)
{
  GLint value = 0;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachment, name, &value);
  return value;
}

/// The attachment of the framebuffer that is drawn to; it draws to one alone.
GLenum GetColorAttachment()
{
  return GetBinding(GL_DRAW_BUFFER0);
}

bool IsTexture(GLenum attachment)
{
  return GetAttachmentParameter(attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE) == GL_TEXTURE;
}

struct Format
{
  GLint Internal = 0;
  GLint Width = 0;
  GLint Height = 0;
};

/// Makes a texture of the format and size of an attachment.
GLuint MakeTextureAs(GLenum attachment)
{
  const GLuint before = GetBinding(GL_TEXTURE_BINDING_2D);
  Format format;
  glBindTexture(GL_TEXTURE_2D,
    static_cast<GLuint>(GetAttachmentParameter(attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME)));
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_INTERNAL_FORMAT, &format.Internal);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &format.Width);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &format.Height);
  GLuint texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  const bool hasDepths = attachment == GL_DEPTH_ATTACHMENT;
  const bool hasStencil =
    hasDepths && GetAttachmentParameter(attachment, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE) > 0;
  // No samples are given, so any format of samples will do that has the same parts.
  GLenum parts = hasDepths ? GL_DEPTH_COMPONENT : GL_RGBA;
  GLenum type = hasDepths ? GL_FLOAT : GL_UNSIGNED_BYTE;
  if (hasStencil)
  {
    parts = GL_DEPTH_STENCIL;
    type = GL_UNSIGNED_INT_24_8;
  }
  glTexImage2D(
    GL_TEXTURE_2D, 0, format.Internal, format.Width, format.Height, 0, parts, type, nullptr);
  glBindTexture(GL_TEXTURE_2D, before);
  return texture;
}

/// Copies colors and depths of a viewport from one framebuffer to another one.
void CopyImage(GLuint from, GLenum fromBuffer, GLuint to, const std::array<int, 4>& viewport)
{
  const GLuint readBefore = GetBinding(GL_READ_FRAMEBUFFER_BINDING);
  const GLuint drawBefore = GetBinding(GL_DRAW_FRAMEBUFFER_BINDING);
  const GLboolean wasCut = glIsEnabled(GL_SCISSOR_TEST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
  const auto bufferBefore = static_cast<GLenum>(GetBinding(GL_READ_BUFFER));
  glReadBuffer(fromBuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
  glDisable(GL_SCISSOR_TEST);
  const int left = viewport[0];
  const int bottom = viewport[1];
  const int right = left + viewport[2];
  const int top = bottom + viewport[3];
  glBlitFramebuffer(left, bottom, right, top, left, bottom, right, top,
    GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  if (wasCut == GL_TRUE)
  {
    glEnable(GL_SCISSOR_TEST);
  }
  glReadBuffer(bufferBefore);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, readBefore);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, drawBefore);
}

} // namespace

bool SavedImage::IsPossible()
{
  return GetBinding(GL_DRAW_FRAMEBUFFER_BINDING) != 0 && IsTexture(GetColorAttachment()) &&
    IsTexture(GL_DEPTH_ATTACHMENT);
}

void SavedImage::Save(const std::array<int, 4>& viewport)
{
  this->Clear();
  this->Viewport = viewport;
  const GLenum color = GetColorAttachment();
  const GLuint shown = GetBinding(GL_DRAW_FRAMEBUFFER_BINDING);
  this->Textures = { MakeTextureAs(color), MakeTextureAs(GL_DEPTH_ATTACHMENT) };
  const bool hasStencil =
    GetAttachmentParameter(GL_DEPTH_ATTACHMENT, GL_FRAMEBUFFER_ATTACHMENT_STENCIL_SIZE) > 0;
  glGenFramebuffers(1, &this->Framebuffer);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, this->Framebuffer);
  glFramebufferTexture2D(
    GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, this->Textures[0], 0);
  glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER,
    hasStencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
    this->Textures[1], 0);
  glDrawBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, shown);
  CopyImage(shown, color, this->Framebuffer, viewport);
}

void SavedImage::Restore() const
{
  CopyImage(this->Framebuffer, GL_COLOR_ATTACHMENT0, GetBinding(GL_DRAW_FRAMEBUFFER_BINDING),
    this->Viewport);
}

void SavedImage::Clear()
{
  if (!this->IsEmpty())
  {
    glDeleteFramebuffers(1, &this->Framebuffer);
    glDeleteTextures(2, this->Textures.data());
    this->Framebuffer = 0;
  }
}

} // namespace isosurface
