// SPDX-License-Identifier: BSD-3-Clause
#include "ProgressDisplay.h"

#include "StopSignal.h"

#include "Ground/Base/PrintableText.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace isosurface
{
namespace
{

constexpr int BarWidth = 30;
constexpr double SecondsBetweenFrames = 0.1;

} // namespace

ProgressDisplay::ProgressDisplay(std::string name, double bytes, bool isShown)
  : Name(std::move(name))
  , Bytes(bytes)
  , IsShown(isShown)
  , IsTerminal(::isatty(STDERR_FILENO) != 0)
{
}

ProgressDisplay::~ProgressDisplay()
{
  this->Clear();
}

void ProgressDisplay::Clear()
{
  if (std::exchange(this->IsDrawn, false))
  {
    std::fputs("\r\033[K", stderr);
    std::fflush(stderr);
  }
}

double ProgressDisplay::GetSeconds() const
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - this->Begin).count();
}

Progress ProgressDisplay::GetProgress()
{
  return [this](double share)
  {
    if (this->IsShown)
    {
      this->Show(std::clamp(share, 0.0, 1.0));
    }
    return !IsStopAsked();
  };
}

void ProgressDisplay::Show(double share)
{
  const double seconds = this->GetSeconds();
  if (this->IsTerminal && seconds - this->LastDrawn >= SecondsBetweenFrames)
  {
    const auto filled = static_cast<std::size_t>(share * BarWidth);
    const std::string bar = std::string(filled, '#') + std::string(BarWidth - filled, '.');
    const double left = share > 0.01 ? seconds / share - seconds : 0;
    std::fprintf(stderr, "\r\033[K%s [%s] %3.0f %%  %s/s", this->Name.c_str(), bar.c_str(),
      100 * share, DescribeBytes(seconds > 0 ? this->Bytes * share / seconds : 0).c_str());
    if (left >= 1)
    {
      std::fprintf(stderr, "  %.0f s left", left);
    }
    std::fflush(stderr);
    this->LastDrawn = seconds;
    this->IsDrawn = true;
  }
  const int tenths = static_cast<int>(share * 10);
  if (!this->IsTerminal && tenths > this->ToldTenths)
  {
    std::fprintf(stderr, "%s: %d %%\n", this->Name.c_str(), 10 * tenths);
    this->ToldTenths = tenths;
  }
}

} // namespace isosurface
