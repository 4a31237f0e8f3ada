// SPDX-License-Identifier: BSD-3-Clause
#include "Store/StoreSpectra.h"

#include "Store/VolumeSpectra.h"

#include <utility>

namespace isosurface
{

StoreSpectra::StoreSpectra(
  std::vector<SpectrumBins> bins, std::uint32_t stores, std::size_t rank, std::size_t ranks)
  : Bins(std::move(bins))
  , Stores(stores)
  , Rank(rank)
  , Ranks(ranks)
{
  for (std::size_t store = rank; store < stores; store += ranks)
  {
    this->Mine.push_back(std::make_unique<Spectra>());
    for (const SpectrumBins& ofArray : this->Bins)
    {
      this->Mine.back()->Arrays.emplace_back(ofArray);
    }
  }
}

void StoreSpectra::Add(std::uint32_t store, std::size_t array, BlockWorkload& counted)
{
  Spectra& spectra = *this->Mine[store / this->Ranks];
  const std::lock_guard<std::mutex> lock(spectra.Mutex);
  counted.MoveTo(spectra.Arrays[array]);
}

Message StoreSpectra::Pack() const
{
  Message message;
  for (const std::unique_ptr<Spectra>& spectra : this->Mine)
  {
    for (const WorkloadSpectrum& spectrum : spectra->Arrays)
    {
      VolumeSpectra::AppendCounts(spectrum, message);
    }
  }
  return message;
}

std::vector<std::vector<WorkloadSpectrum>> StoreSpectra::Unpack(
  const std::vector<Message>& messages) const
{
  std::vector<std::vector<WorkloadSpectrum>> spectra;
  for (const SpectrumBins& bins : this->Bins)
  {
    spectra.emplace_back(this->Stores, WorkloadSpectrum(bins));
  }
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    std::size_t position = 0;
    for (std::size_t store = rank; store < this->Stores; store += this->Ranks)
    {
      for (std::vector<WorkloadSpectrum>& ofArray : spectra)
      {
        VolumeSpectra::TakeCounts(messages[rank], position, ofArray[store]);
      }
    }
  }
  return spectra;
}

std::uint64_t StoreSpectra::GetBytes(
  const std::vector<SpectrumBins>& bins, std::uint32_t stores, std::size_t rank, std::size_t ranks)
{
  // Two counts a bin. A JSON number takes 16 bytes as a value and up to 21 in each of two texts.
  constexpr std::uint64_t countBytes = 2 * sizeof(std::uint64_t);
  constexpr std::uint64_t jsonBytes = 2 * (16 + 2 * 21);
  std::uint64_t bytes = 0;
  for (const SpectrumBins& ofArray : bins)
  {
    bytes += ofArray.Count * (stores / ranks + 1) * countBytes;
    bytes += rank == 0 ? ofArray.Count * std::uint64_t{ stores } * (2 * countBytes + jsonBytes) : 0;
  }
  return bytes;
}

} // namespace isosurface
