// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSpectrumSource
 * @brief   brings the contour spectrum of a contour's input to the window
 *
 * Makes a Contour Spectrum behind the contour's input that nobody sees: it is in no pipeline
 * browser, state, trace or undo stack. Of a server only the spectrum itself travels, some ten
 * thousand numbers. Array and component are those that the panel shows, applied or not. That of many
 * samples in memory is counted beside the window.
 */

#ifndef pqSpectrumSource_h
#define pqSpectrumSource_h

#include "SpectrumCurve.h"

#include "vtkSmartPointer.h"

#include <QObject>

class pqTimer;
class vtkSMProxy;
class vtkSMSourceProxy;

class pqSpectrumSource : public QObject
{
  Q_OBJECT

public:
  explicit pqSpectrumSource(vtkSMProxy* contour, QObject* parent = nullptr);

  /// Whether the spectrum stands in a file: then it costs one small read.
  bool IsStored() const;

  /// The spectrum at a time; empty if there is none, or if it is being counted. Waits for the server.
  isosurface::SpectrumCurve Fetch(double time);
  /// The share of the volume that the last one is of.
  double GetShare() const { return this->Share; }
  /// Whether counted() will tell that it can be fetched.
  bool IsCounting() const;

  /// Whether the samples of the chosen array and component are whole numbers.
  bool HasIntegers() const;

Q_SIGNALS:
  void counted();

private Q_SLOTS:
  void Advance();

private:
  vtkSMSourceProxy* GetInput(unsigned int& port) const;

  vtkSmartPointer<vtkSMProxy> Contour;
  vtkSmartPointer<vtkSMSourceProxy> Spectrum;
  double Share = 1;
  pqTimer* Timer; ///< owned by this object; ParaView's test player waits for such timers
};

#endif
