// SPDX-License-Identifier: BSD-3-Clause
#include "Storage/Index/IntervalListWriter.h"

#include <algorithm>

namespace isosurface
{

IntervalListWriter::IntervalListWriter(PagedFileWriter& file)
  : File(file)
  , RecordsPerPage(IntervalTreeFormat::GetRecordsPerPage(file.GetPayloadSize()))
  , Payload(file.GetPayloadSize())
{
}

Result<IntervalList> IntervalListWriter::Begin(std::uint32_t count)
{
  if (this->Page == 0 || (this->Record > 0 && this->RecordsPerPage - this->Record < count))
  {
    ISOSURFACE_RETURN_IF_ERROR(this->EndPage());
    ISOSURFACE_RETURN_IF_ERROR(this->BeginPage());
  }
  IntervalList list;
  list.Page = this->Page;
  list.Record = static_cast<std::uint16_t>(this->Record);
  list.Count = count;
  return list;
}

Status IntervalListWriter::Add(const KeyInterval& interval)
{
  if (this->Record == this->RecordsPerPage)
  {
    ISOSURFACE_RETURN_IF_ERROR(this->EndPage());
    ISOSURFACE_RETURN_IF_ERROR(this->BeginPage());
  }
  IntervalRecordPage::Put(this->Payload.data(), this->Record++, interval);
  return Status::Ok();
}

Status IntervalListWriter::Finish()
{
  return this->EndPage();
}

Status IntervalListWriter::BeginPage()
{
  ISOSURFACE_ASSIGN_OR_RETURN(this->Page, this->File.AllocatePage());
  this->Record = 0;
  std::fill(this->Payload.begin(), this->Payload.end(), std::uint8_t(0));
  IntervalRecordPage::Begin(this->Payload.data());
  return Status::Ok();
}

Status IntervalListWriter::EndPage()
{
  return this->Page == 0 ? Status::Ok() : this->File.WritePage(this->Page, this->Payload.data());
}

} // namespace isosurface
