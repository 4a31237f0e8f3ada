// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SurfaceArrays_h
#define isosurface_SurfaceArrays_h

#include "Ground/Base/Buffer.h"
#include "Ground/Base/KeptMemory.h"
#include "Surface/Contour/Surface.h"

#include <pybind11/numpy.h>

#include <string>
#include <vector>

namespace isosurface
{

/// An array of a type of samples.
pybind11::dtype MakeDtype(ValueType type);

/// An array that owns the memory of a buffer, which becomes empty.
template <typename T>
pybind11::array AdoptBuffer(
  Buffer<T>& buffer, const pybind11::dtype& type, const std::vector<pybind11::ssize_t>& shape)
{
  if (buffer.IsEmpty())
  {
    return pybind11::array(type, shape);
  }
  T* const data = buffer.Release();
  const pybind11::capsule owner(data, [](void* memory) { ReleaseMemory(memory); });
  return pybind11::array(type, shape, data, owner);
}

/// What Python's Surface is made of, by the names of its arguments. The arrays take over the memory
/// of the surface. `normals`: whether it has them. `attributes`: the names of its attributes.
pybind11::dict MakeSurfaceArrays(
  Surface surface, bool normals, const std::vector<std::string>& attributes);

} // namespace isosurface

#endif
