// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkInformationStabbingRequestKey
 * @brief   carries a vtkStabbingRequest from a consumer up to the reader
 *
 * The key passes upstream only through algorithms that are known to hand the samples on unchanged
 * (see IsTransparent()). Behind any other filter the request would be a wrong one: a smoothed array
 * crosses an isovalue in other blocks than the stored array does.
 *
 * As with vtkInformationIntegerRequestKey, what an execution answered is stored with the data, and
 * the reader executes again only if the next request differs. An absent request equals an empty
 * one.
 */

#ifndef vtkInformationStabbingRequestKey_h
#define vtkInformationStabbingRequestKey_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkInformationObjectBaseKey.h"

class vtkStabbingRequest;

class ISOSURFACEREADERS_EXPORT vtkInformationStabbingRequestKey : public vtkInformationObjectBaseKey
{
public:
  vtkTypeMacro(vtkInformationStabbingRequestKey, vtkInformationObjectBaseKey);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkInformationStabbingRequestKey(const char* name, const char* location);
  ~vtkInformationStabbingRequestKey() override;

  vtkStabbingRequest* GetRequest(vtkInformation* info);

  /**
   * Takes the request back from this pipeline information and from all that it was copied to
   * upstream. A consumer calls it when it has been served: other consumers of the same ports, which
   * know nothing of the key, must not inherit the request.
   */
  void Withdraw(vtkInformation* info);

  /**
   * Whether the algorithm whose output information this is passes point data on unchanged.
   */
  static bool IsTransparent(vtkInformation* outputInfo);

  void CopyDefaultInformation(
    vtkInformation* request, vtkInformation* fromInfo, vtkInformation* toInfo) override;
  bool NeedToExecute(vtkInformation* pipelineInfo, vtkInformation* dobjInfo) override;
  void StoreMetaData(
    vtkInformation* request, vtkInformation* pipelineInfo, vtkInformation* dobjInfo) override;

private:
  vtkInformationStabbingRequestKey(const vtkInformationStabbingRequestKey&) = delete;
  void operator=(const vtkInformationStabbingRequestKey&) = delete;
};

#endif
