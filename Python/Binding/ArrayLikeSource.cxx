// SPDX-License-Identifier: BSD-3-Clause
#include "ArrayLikeSource.h"

#include "SurfaceArrays.h"

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <utility>

namespace isosurface
{
namespace
{

pybind11::slice MakeSlice(const VertexBox& box, std::size_t axis)
{
  return { static_cast<pybind11::ssize_t>(box.Low[axis]),
    static_cast<pybind11::ssize_t>(box.High[axis]), 1 };
}

/// The samples of a box, as an array of the type. Throws Python's exceptions.
pybind11::array TakeSlice(const ArrayLike& array, const VertexBox& box)
{
  const pybind11::tuple key =
    pybind11::make_tuple(MakeSlice(box, 2), MakeSlice(box, 1), MakeSlice(box, 0));
  const pybind11::object slice = array.Object[key];
  const pybind11::module_ numpy = pybind11::module_::import("numpy");
  pybind11::array samples = numpy.attr("asarray")(slice, MakeDtype(array.Type));
  const Index3 size = box.GetSize();
  // Of one component the last axis may be there or not.
  const bool hasComponents = samples.ndim() == 4;
  bool fits = hasComponents || (samples.ndim() == 3 && array.Components == 1);
  for (pybind11::ssize_t axis = 0; fits && axis < 3; ++axis)
  {
    fits = samples.shape(axis) == size[static_cast<std::size_t>(2 - axis)];
  }
  if (!fits || (hasComponents && samples.shape(3) != array.Components))
  {
    throw pybind11::value_error("a slice of the array has not the shape that was asked for");
  }
  for (pybind11::ssize_t axis = 0; axis < samples.ndim(); ++axis)
  {
    if (samples.strides(axis) % samples.itemsize() != 0)
    {
      return numpy.attr("ascontiguousarray")(samples);
    }
  }
  return samples;
}

/// Views of the components of an array of the samples in a box.
void AddViews(const pybind11::array& samples, const ArrayLike& array, const VertexBox& box,
  std::vector<SampleView>& views)
{
  const pybind11::ssize_t size = samples.itemsize();
  SampleView view;
  view.Type = array.Type;
  view.Box = box;
  view.Available = box;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    view.Stride[axis] = samples.strides(static_cast<pybind11::ssize_t>(2 - axis)) / size;
  }
  for (int component = 0; component < array.Components; ++component)
  {
    const pybind11::ssize_t offset = component > 0 ? component * samples.strides(3) : 0;
    view.First = static_cast<const char*>(samples.data()) + offset;
    views.push_back(view);
  }
}

} // namespace

ArrayLikeSource::ArrayLikeSource(
  std::vector<ArrayLike> arrays, const Index3& dimensions, const std::optional<Index3>& chunk)
  : Arrays(std::move(arrays))
  , Box{ { 0, 0, 0 }, dimensions }
  , Chunk(chunk)
{
}

std::uint64_t ArrayLikeSource::GetReadBytes(const VertexBox& box) const
{
  std::uint64_t bytes = 0;
  for (const ArrayLike& array : this->Arrays)
  {
    bytes += GetValueSize(array.Type) * static_cast<std::uint64_t>(array.Components);
  }
  // The slice, and another one where it has to be joined or converted.
  return 2 * bytes * static_cast<std::uint64_t>(box.GetNumberOfVertices());
}

Result<BoxSamples> ArrayLikeSource::Read(const VertexBox& box)
{
  const pybind11::gil_scoped_acquire held;
  try
  {
    using Slices = std::vector<pybind11::array>;
    const std::shared_ptr<Slices> slices(new Slices,
      [](Slices* owned)
      {
        const pybind11::gil_scoped_acquire heldToFree;
        delete owned;
      });
    BoxSamples samples;
    for (const ArrayLike& array : this->Arrays)
    {
      slices->push_back(TakeSlice(array, box));
      AddViews(slices->back(), array, box, samples.Arrays);
    }
    samples.Owner = slices;
    return samples;
  }
  catch (pybind11::error_already_set& error)
  {
    this->Raised = error;
    return Status(StatusCode::IoError, error.what());
  }
  catch (const std::exception& error)
  {
    return Status(StatusCode::InvalidArgument, error.what());
  }
}

void ArrayLikeSource::Rethrow() const
{
  if (this->Raised)
  {
    throw pybind11::error_already_set(*this->Raised);
  }
}

} // namespace isosurface
