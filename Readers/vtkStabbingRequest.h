// SPDX-FileCopyrightText: Copyright (c) 2026, the ScalableIsosurface authors
// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkStabbingRequest
 * @brief   what a consumer wants of a blocked volume: the blocks that some isovalues cross
 *
 * Travels upstream in the pipeline information under
 * vtkBlockedVolumeReader::STABBING_REQUEST(). A request is not changed once it has been put there.
 * A request without isovalues asks for nothing in particular: the reader then gives the finest
 * level that fits its memory limit. A request with HandleOnly says that the consumer takes its
 * blocks through the vtkBlockedVolumeHandle: any output will do, an existing one is left as it is.
 */

#ifndef vtkStabbingRequest_h
#define vtkStabbingRequest_h

#include "IsosurfaceReadersModule.h" // For export macro
#include "vtkObject.h"

#include <memory> // For the selection
#include <string> // For the array's name
#include <vector> // For the isovalues

namespace isosurface
{
struct BlockSelection;
}

class ISOSURFACEREADERS_EXPORT vtkStabbingRequest : public vtkObject
{
public:
  static vtkStabbingRequest* New();
  vtkTypeMacro(vtkStabbingRequest, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The point array whose isosurfaces are wanted, by name.
   */
  void SetArrayName(const std::string& name);
  const std::string& GetArrayName() const { return this->ArrayName; }
  ///@}

  ///@{
  /**
   * Which component of that array, or, if it is their number, the magnitude. Any will do for an
   * array of one component. Default 0.
   */
  vtkSetMacro(Component, int);
  vtkGetMacro(Component, int);
  ///@}

  ///@{
  /**
   * The isovalues; a block is wanted if it is crossed by at least one of them.
   */
  void SetIsovalues(const std::vector<double>& isovalues);
  const std::vector<double>& GetIsovalues() const { return this->Isovalues; }
  ///@}

  ///@{
  /**
   * The level of detail of the blocks, 0 (full resolution) by default; of a volume with fewer
   * levels the coarsest.
   */
  vtkSetMacro(Level, int);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * Which blocks are wanted beside those, or not; see isosurface::BlockSelection.
   */
  void SetSelection(const isosurface::BlockSelection& selection);
  const isosurface::BlockSelection& GetSelection() const { return *this->Selection; }
  ///@}

  ///@{
  /**
   * Whether no blocks are wanted in the reader's output.
   */
  vtkSetMacro(HandleOnly, bool);
  vtkGetMacro(HandleOnly, bool);
  ///@}

  /**
   * Whether an output that was made for one request serves another one; a null request asks for
   * nothing in particular.
   */
  static bool Serves(const vtkStabbingRequest* made, const vtkStabbingRequest* wanted);

protected:
  vtkStabbingRequest();
  ~vtkStabbingRequest() override;

private:
  vtkStabbingRequest(const vtkStabbingRequest&) = delete;
  void operator=(const vtkStabbingRequest&) = delete;

  std::string ArrayName;
  std::vector<double> Isovalues;
  int Component = 0;
  int Level = 0;
  std::unique_ptr<isosurface::BlockSelection> Selection;
  bool HandleOnly = false;
};

#endif
