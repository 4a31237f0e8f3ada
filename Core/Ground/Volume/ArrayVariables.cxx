// SPDX-License-Identifier: BSD-3-Clause
#include "Ground/Volume/ArrayVariables.h"

namespace isosurface
{

ArrayVariables::ArrayVariables(const std::vector<ArrayDescription>& arrays)
{
  for (std::size_t array = 0; array < arrays.size(); ++array)
  {
    this->Components.push_back(arrays[array].Components);
    this->First.push_back(this->Variables.size());
    for (int component = 0; component < arrays[array].Components; ++component)
    {
      this->Variables.push_back({ array, component, arrays[array].Type });
      this->StoredTypes.push_back(arrays[array].Type);
    }
  }
  for (std::size_t array = 0; array < arrays.size(); ++array)
  {
    if (arrays[array].Components > 1)
    {
      this->Variables.push_back({ array, Variable::Magnitude, ValueType::Float64 });
    }
  }
}

std::optional<std::size_t> ArrayVariables::Find(std::size_t array, int component) const
{
  if (array >= this->Components.size() || component >= this->Components[array])
  {
    return std::nullopt;
  }
  if (component >= 0)
  {
    return this->First[array] + static_cast<std::size_t>(component);
  }
  if (this->Components[array] == 1)
  {
    return this->First[array];
  }
  for (std::size_t variable = this->GetNumberOfStored(); variable < this->GetCount(); ++variable)
  {
    if (this->Variables[variable].Array == array)
    {
      return variable;
    }
  }
  return std::nullopt;
}

std::optional<std::size_t> ArrayVariables::FindChoice(std::size_t array, int choice) const
{
  if (array >= this->Components.size())
  {
    return std::nullopt;
  }
  const std::optional<int> component = FindChosenComponent(this->Components[array], choice);
  return component ? this->Find(array, *component) : std::nullopt;
}

std::optional<int> FindChosenComponent(int components, int choice)
{
  if (components == 1)
  {
    return 0;
  }
  if (choice < 0 || choice > components)
  {
    return std::nullopt;
  }
  return choice == components ? Variable::Magnitude : choice;
}

} // namespace isosurface
