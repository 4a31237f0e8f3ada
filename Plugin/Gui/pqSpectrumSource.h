// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqSpectrumSource
 * @brief   brings the contour spectrum of a contour's input to the window
 *
 * Makes a Contour Spectrum behind the contour's input that nobody sees: it is in no pipeline
 * browser, state, trace or undo stack. Of a server only the spectrum itself travels, some ten
 * thousand numbers. Array and component are those that the panel shows, applied or not.
 */

#ifndef pqSpectrumSource_h
#define pqSpectrumSource_h

#include "SpectrumCurve.h"

#include "vtkSmartPointer.h"

#include <QObject>

class vtkSMProxy;
class vtkSMSourceProxy;

class pqSpectrumSource : public QObject
{
  Q_OBJECT

public:
  explicit pqSpectrumSource(vtkSMProxy* contour, QObject* parent = nullptr);
  ~pqSpectrumSource() override;

  /// Whether the spectrum stands in a file: then it costs one small read.
  bool IsStored() const;

  /// Samples that would be visited to count it; 0 if it is stored.
  double CountSamples() const;

  /// The spectrum at a time; empty if there is none. Waits for the server.
  isosurface::SpectrumCurve Fetch(double time);

  /// Whether the samples of the chosen array and component are whole numbers.
  bool HasIntegers() const;

private:
  Q_DISABLE_COPY(pqSpectrumSource)

  vtkSMSourceProxy* GetInput(unsigned int& port) const;

  vtkSmartPointer<vtkSMProxy> Contour;
  vtkSmartPointer<vtkSMSourceProxy> Spectrum;
};

#endif
