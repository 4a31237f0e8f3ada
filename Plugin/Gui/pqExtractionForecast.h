// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqExtractionForecast
 * @brief   predicts how long surfaces take, from how long earlier ones of a server took
 *
 * One a server, so that a new contour knows what others learned. What is learned comes from the
 * field data of surfaces, which the window has anyway; time that load has added is left out
 * (UnloadedRate).
 */

#ifndef pqExtractionForecast_h
#define pqExtractionForecast_h

#include "SpectrumCurve.h"
#include "UnloadedRate.h"

#include <QObject>

class pqServer;
class vtkSMSourceProxy;

class pqExtractionForecast : public QObject
{
  Q_OBJECT

public:
  /// That of a server, which owns it.
  static pqExtractionForecast* Of(pqServer* server);

  /// Learns from a contour's last surface, once.
  void Learn(vtkSMSourceProxy* contour);

  /// Seconds of a surface with its blocks in memory. forecast: of all ranks together.
  double PredictFromMemory(const isosurface::IsosurfaceForecast& forecast) const;
  /// The same with all blocks read from disk.
  double PredictFromDisk(const isosurface::IsosurfaceForecast& forecast) const;

private:
  explicit pqExtractionForecast(pqServer* server);

  double Ranks;
  isosurface::UnloadedRate Rate;
  double LastSeconds = -1; ///< of what was learned from last
};

#endif
