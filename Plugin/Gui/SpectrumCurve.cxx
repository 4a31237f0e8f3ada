// SPDX-License-Identifier: BSD-3-Clause
#include "SpectrumCurve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace isosurface
{

SpectrumCurve::SpectrumCurve(std::vector<double> isovalues, Columns columns, bool integers)
  : Isovalues(std::move(isovalues))
  , Values(std::move(columns))
  , Integers(integers)
{
  for (std::vector<double>& values : this->Values)
  {
    if (values.size() != this->Isovalues.size())
    {
      values.clear();
    }
  }
}

const std::vector<double>& SpectrumCurve::Get(Quantity quantity) const
{
  return this->Values[static_cast<std::size_t>(quantity)];
}

double SpectrumCurve::Evaluate(Quantity quantity, double isovalue) const
{
  const std::vector<double>& values = this->Get(quantity);
  const double asked = this->Integers ? std::ceil(isovalue) : isovalue;
  if (values.empty() || !(asked >= this->Isovalues.front()) || asked > this->Isovalues.back())
  {
    return 0;
  }
  const auto above = std::lower_bound(this->Isovalues.begin(), this->Isovalues.end(), asked);
  const auto index = static_cast<std::size_t>(above - this->Isovalues.begin());
  if (*above == asked)
  {
    return values[index];
  }
  const double low = this->Isovalues[index - 1];
  const double share = (asked - low) / (*above - low);
  return values[index - 1] + share * (values[index] - values[index - 1]);
}

IsosurfaceForecast SpectrumCurve::Forecast(double isovalue) const
{
  IsosurfaceForecast forecast;
  forecast.Triangles = std::round(this->Evaluate(Quantity::Triangles, isovalue));
  forecast.Blocks = std::round(this->Evaluate(Quantity::ActiveBlocks, isovalue));
  forecast.Bytes = std::round(this->Evaluate(Quantity::Bytes, isovalue));
  forecast.Area = this->Evaluate(Quantity::Area, isovalue);
  return forecast;
}

std::vector<double> SpectrumCurve::MakeHistogram() const
{
  const std::vector<double>& volume = this->Get(Quantity::Volume);
  std::vector<double> histogram;
  for (std::size_t index = 0; index + 1 < volume.size(); ++index)
  {
    histogram.push_back(std::max(0.0, volume[index] - volume[index + 1]));
  }
  return histogram;
}

bool SpectrumCurve::SpansDecades(Quantity quantity) const
{
  double minimum = std::numeric_limits<double>::infinity();
  double maximum = 0;
  for (const double value : this->Get(quantity))
  {
    if (value > 0)
    {
      minimum = std::min(minimum, value);
      maximum = std::max(maximum, value);
    }
  }
  return maximum > 100 * minimum;
}

} // namespace isosurface
