// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkSMIsovalueDomain
 * @brief   the range of an array, with an isovalue that shows something as the default
 *
 * In Hounsfield units the default is bone, if the range has it; else vtkContourSpectrum proposes it. The
 * input must have been executed once, or be one of this plugin's readers, which tell it from their
 * files. Else, and where there is nothing to propose, the default is that of vtkSMArrayRangeDomain.
 */

#ifndef vtkSMIsovalueDomain_h
#define vtkSMIsovalueDomain_h

#include "IsosurfaceRepresentationModule.h" // For export macro
#include "vtkSMArrayRangeDomain.h"

#include <array> // For a range

class vtkSMProxy;

class ISOSURFACEREPRESENTATION_EXPORT vtkSMIsovalueDomain : public vtkSMArrayRangeDomain
{
public:
  static vtkSMIsovalueDomain* New();
  vtkTypeMacro(vtkSMIsovalueDomain, vtkSMArrayRangeDomain);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  int SetDefaultValues(vtkSMProperty* property, bool useUnchecked) override;

protected:
  vtkSMIsovalueDomain() = default;
  ~vtkSMIsovalueDomain() override = default;

private:
  vtkSMIsovalueDomain(const vtkSMIsovalueDomain&) = delete;
  void operator=(const vtkSMIsovalueDomain&) = delete;

  /// NaN if there is nothing to propose.
  double Propose();
  /// Of the array: what is known before, or else what the spectrum tells.
  std::array<double, 2> FindRange(vtkSMProxy* spectrum);
};

#endif
