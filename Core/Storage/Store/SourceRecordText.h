// SPDX-License-Identifier: BSD-3-Clause
#ifndef isosurface_SourceRecordText_h
#define isosurface_SourceRecordText_h

#include "Storage/Store/JsonDocument.h"
#include "Storage/Store/SourceRecord.h"

namespace isosurface
{

/// The member "source" of a header's time step.
Json FormatSource(const SourceRecord& record);
/// Errors are those of JsonMembers; SourceRecord::Validate() checks the rest.
SourceRecord ReadSource(JsonMembers& members);

} // namespace isosurface

#endif
