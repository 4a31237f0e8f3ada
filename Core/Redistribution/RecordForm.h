// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_RecordForm_h
#define isosurface_RecordForm_h

#include "EdgeIndex/EdgeIndexHeader.h"
#include "Redistribution/SurfaceForm.h"

namespace isosurface
{

/**
 * A block as its edge-index records, one an isovalue that crosses it. Blocks are decoded when
 * marching cubes visits them; points that blocks share are made once.
 *
 * Memory: see EdgeIndexBlockDecoder and ExtractSurface.
 */
class RecordForm : public SurfaceForm
{
public:
  /// Both must outlive the form. See JoinIsovalues for the request.
  RecordForm(const EdgeIndexHeader& header, const ContourRequest& request)
    : Header(header)
    , Request(request)
  {
  }

  Status Pack(
    BlockSource& source, int threads, const Take& take, const Progress& progress) const override;
  Result<Surface> Unpack(
    ArrivingBlocks& blocks, int threads, const Progress& progress) const override;

private:
  const EdgeIndexHeader& Header;
  const ContourRequest& Request;
};

} // namespace isosurface

#endif
