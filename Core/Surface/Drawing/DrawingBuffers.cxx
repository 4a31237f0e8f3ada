// SPDX-License-Identifier: BSD-3-Clause
#include "Surface/Drawing/DrawingBuffers.h"

#include "Ground/Base/ParallelFor.h"
#include "Surface/Drawing/PointPlaces.h"

#include <cmath>

namespace isosurface
{
namespace
{

constexpr std::size_t TuplesOfRun = std::size_t{ 1 } << 16;

/// Calls body(first, last) for runs of [0, count), by several threads at once.
template <typename BodyT>
void ForTupleRuns(std::size_t count, int threads, BodyT&& body)
{
  ParallelFor((count + TuplesOfRun - 1) / TuplesOfRun, threads,
    [&](std::size_t run, int)
    { body(run * TuplesOfRun, std::min(count, (run + 1) * TuplesOfRun)); });
}

template <typename T>
void CopyRun(const TriangleSurface& surface, const T* connectivity, std::size_t first,
  std::size_t last, bool allProper, std::uint32_t* indices)
{
  if (allProper)
  {
    std::transform(connectivity + 3 * first, connectivity + 3 * last, indices,
      [](T point) { return static_cast<std::uint32_t>(point); });
    return;
  }
  for (std::size_t triangle = first; triangle < last; ++triangle)
  {
    const T* points = connectivity + 3 * triangle;
    const PointVector a = LoadPoint(surface, static_cast<std::size_t>(points[0]));
    const PointVector b = LoadPoint(surface, static_cast<std::size_t>(points[1]));
    const PointVector c = LoadPoint(surface, static_cast<std::size_t>(points[2]));
    if (AreProperCorners(a, b, c))
    {
      *indices++ = static_cast<std::uint32_t>(points[0]);
      *indices++ = static_cast<std::uint32_t>(points[1]);
      *indices++ = static_cast<std::uint32_t>(points[2]);
    }
  }
}

template <typename T>
double GetValue(const T* tuple, int components, int component)
{
  if (component >= 0)
  {
    return static_cast<double>(tuple[component]);
  }
  double sum = 0;
  for (int each = 0; each < components; ++each)
  {
    const auto value = static_cast<double>(tuple[each]);
    sum += value * value;
  }
  return std::sqrt(sum);
}

} // namespace

void CopyProperTriangles(const TriangleSurface& surface, const std::vector<std::uint32_t>& counts,
  std::size_t firstRun, std::size_t lastRun, std::uint32_t* indices, int threads)
{
  constexpr std::size_t length = TriangleMeasure::TrianglesOfRun;
  std::vector<std::size_t> starts;
  std::size_t start = 0;
  for (std::size_t run = firstRun; run < lastRun; ++run)
  {
    starts.push_back(start);
    start += counts[run];
  }
  WithConnectivity(surface.Connectivity,
    [&](const auto* connectivity)
    {
      ParallelFor(starts.size(), threads,
        [&](std::size_t n, int)
        {
          const std::size_t run = firstRun + n;
          const std::size_t first = run * length;
          const std::size_t last = std::min(surface.NumberOfTriangles, first + length);
          CopyRun(surface, connectivity, first, last, counts[run] == last - first,
            indices + 3 * starts[n]);
        });
    });
}

void ShiftAndScale(const float* points, std::size_t count, const double shift[3],
  const double scale[3], float* result, int threads)
{
  ForTupleRuns(count, threads,
    [&](std::size_t first, std::size_t last)
    {
      for (std::size_t point = first; point < last; ++point)
      {
        for (std::size_t axis = 0; axis < 3; ++axis)
        {
          result[3 * point + axis] = static_cast<float>(
            (static_cast<double>(points[3 * point + axis]) - shift[axis]) * scale[axis]);
        }
      }
    });
}

void CopyValues(const float* values, std::size_t count, float* result, int threads)
{
  ForTupleRuns(count, threads,
    [&](std::size_t first, std::size_t last)
    { std::copy(values + first, values + last, result + first); });
}

template <typename T>
void FindTextureCoordinates(const T* values, std::size_t count, int components, int component,
  const TextureRange& range, float* coordinates, int threads)
{
  const double texel = (range.Maximum - range.Minimum) / static_cast<double>(range.Colors);
  const double low = range.Minimum - texel;
  const double high = range.Maximum + texel;
  const double perWidth = 1.0 / (high - low);
  const int chosen = component < components ? component : -1;
  ForTupleRuns(count, threads,
    [&](std::size_t first, std::size_t last)
    {
      for (std::size_t tuple = first; tuple < last; ++tuple)
      {
        const double value =
          GetValue(values + tuple * static_cast<std::size_t>(components), components, chosen);
        const bool isNumber = !std::isnan(value);
        const float place = isNumber ? static_cast<float>((value - low) * perWidth) : 0.5F;
        // Not std::clamp: a range without width gives a NaN, which is to stay one.
        coordinates[2 * tuple] = place > 1000.0F ? 1000.0F : place < -1000.0F ? -1000.0F : place;
        coordinates[2 * tuple + 1] = isNumber ? 0.49F : 1.0F;
      }
    });
}

#define ISOSURFACE_INSTANTIATE(T)          \
  template void FindTextureCoordinates<T>( \
    const T*, std::size_t, int, int, const TextureRange&, float*, int)
ISOSURFACE_INSTANTIATE(float);
ISOSURFACE_INSTANTIATE(double);
ISOSURFACE_INSTANTIATE(char);
ISOSURFACE_INSTANTIATE(signed char);
ISOSURFACE_INSTANTIATE(unsigned char);
ISOSURFACE_INSTANTIATE(short);
ISOSURFACE_INSTANTIATE(unsigned short);
ISOSURFACE_INSTANTIATE(int);
ISOSURFACE_INSTANTIATE(unsigned int);
ISOSURFACE_INSTANTIATE(long);
ISOSURFACE_INSTANTIATE(unsigned long);
ISOSURFACE_INSTANTIATE(long long);
ISOSURFACE_INSTANTIATE(unsigned long long);
#undef ISOSURFACE_INSTANTIATE

} // namespace isosurface
