// SPDX-License-Identifier: BSD-3-Clause
#include "EdgeIndex/BlockCoding.txx"

namespace isosurface
{

void CodeBlock(RangeEncoder& coder, BlockModel& model, const BlockContent& content,
  BlockValues& values, CoderInstructions instructions)
{
  CodeByScheme(coder, model, content, values, instructions);
}

} // namespace isosurface
