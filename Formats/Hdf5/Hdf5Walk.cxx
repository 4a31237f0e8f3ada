// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Hdf5/Hdf5Walk.h"

namespace isosurface
{
namespace
{

constexpr std::size_t MaximumObjectsOfList = 10000;
/// Programs may open as many within seconds.
constexpr std::size_t MaximumObjects = 100000;

} // namespace

Status Hdf5Walk::VisitOnce(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit)
{
  Hdf5Walk walk(links, visit, true);
  H5O_info_t info = {};
  if (links.FindObject(file.Get(), "/", info))
  {
    walk.Known.insert(info.addr);
  }
  return walk.EnterGroup(links.OpenGroup(file.Get(), "/"));
}

Status Hdf5Walk::VisitAll(const Hdf5Handle& file, Hdf5LinkedFiles& links, const Visitor& visit)
{
  return Hdf5Walk(links, visit, false).EnterGroup(links.OpenGroup(file.Get(), "/"));
}

Status Hdf5Walk::MakeError(StatusCode code, const std::string& reason) const
{
  return Status(code, (this->Path.empty() ? "/" : this->Path) + ": cannot be read: " + reason);
}

herr_t Hdf5Walk::Enter(hid_t group, const char* name, const H5L_info_t* info, void* walk)
{
  auto* self = static_cast<Hdf5Walk*>(walk);
  const std::size_t size = self->Path.size();
  self->Path += std::string("/") + name;
  self->Outcome = self->EnterObject(group, name, info->type);
  self->Path.resize(size);
  return !self->Outcome.IsOk() || (self->IsOnce && self->Objects > MaximumObjectsOfList) ? 1 : 0;
}

Status Hdf5Walk::EnterGroup(const Hdf5Handle& group)
{
  hsize_t at = 0;
  ++this->Depth;
  const herr_t code =
    ::H5Literate(group.Get(), H5_INDEX_NAME, H5_ITER_INC, &at, Hdf5Walk::Enter, this);
  --this->Depth;
  return code >= 0 ? this->Outcome : this->MakeError(StatusCode::Corrupt, FindHdf5Reason());
}

Status Hdf5Walk::EnterObject(hid_t group, const std::string& name, H5L_type_t link)
{
  ++this->Objects;
  if (this->IsOnce && (link != H5L_TYPE_HARD || this->Objects > MaximumObjectsOfList))
  {
    return Status::Ok();
  }
  if (this->Objects > MaximumObjects)
  {
    return this->MakeError(StatusCode::Unsupported,
      "the file has more than " + std::to_string(MaximumObjects) + " objects");
  }
  H5O_info_t info = {};
  if (!this->Links.FindObject(group, name, info))
  {
    const std::string& refusal = Hdf5LinkedFiles::GetRefusal();
    return !refusal.empty() ? this->MakeError(StatusCode::Unsupported, refusal)
      : this->IsOnce        ? this->MakeError(StatusCode::Corrupt, FindHdf5Reason())
                            : Status::Ok(); // a link to nothing
  }
  return this->IsOnce && !this->Known.insert(info.addr).second
    ? Status::Ok()
    : this->EnterKind(group, name, info.type);
}

Status Hdf5Walk::EnterKind(hid_t group, const std::string& name, H5O_type_t kind)
{
  if (kind == H5O_TYPE_DATASET)
  {
    const Hdf5Handle dataset = this->Links.OpenDataset(group, name);
    return dataset.IsOpen() ? this->Visit(dataset, this->Path)
                            : this->MakeError(StatusCode::Corrupt, FindHdf5Reason());
  }
  if (kind != H5O_TYPE_GROUP)
  {
    return Status::Ok();
  }
  if (this->Depth < MaximumDepth)
  {
    return this->EnterGroup(this->Links.OpenGroup(group, name));
  }
  return this->IsOnce
    ? Status::Ok()
    : this->MakeError(StatusCode::Unsupported,
        "its groups are in one another, deeper than " + std::to_string(MaximumDepth));
}

} // namespace isosurface
