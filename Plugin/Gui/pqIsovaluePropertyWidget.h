// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqIsovaluePropertyWidget
 * @brief   isovalues in the Properties panel: a chart of the spectrum above ParaView's list
 *
 * Chart and list are both linked to the property, as any widget of ParaView is, so the isovalues
 * are in one place: undo, trace and state files see the property alone. While a handle is dragged
 * with Live on (or Auto Apply), the panel is applied, and one drag is one step to undo.
 *
 * In a panel: panel_widget="isovalue_chooser" at a property of isovalues of a proxy that has
 * Input, SelectInputScalars and Component.
 */

#ifndef pqIsovaluePropertyWidget_h
#define pqIsovaluePropertyWidget_h

#include "pqDoubleVectorPropertyWidget.h"

#include "vtkNew.h"

class pqIsovalueChart;
class pqServer;
class pqSpectrumSource;
class pqTimer;
class QCheckBox;
class QComboBox;
class QWidget;
class vtkEventQtSlotConnect;
class vtkSMProxy;

namespace isosurface
{
struct IsosurfaceForecast;
}

class pqIsovaluePropertyWidget : public pqDoubleVectorPropertyWidget
{
  Q_OBJECT
  typedef pqDoubleVectorPropertyWidget Superclass;

public:
  pqIsovaluePropertyWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent = nullptr);
  ~pqIsovaluePropertyWidget() override;

  void select() override;

protected:
  void showEvent(QShowEvent* event) override;

private Q_SLOTS:
  void ExpectSpectrum();
  void FetchSpectrum();
  void LearnFromSurface();
  void UpdateColors();
  void BeginDrag();
  void EndDrag();
  void FollowIfLive();
  void ApplyNow();
  void UpdateTissues();

private:
  void LayOut();
  void LayOutTissues();
  void ToggleIsovalue(double isovalue);
  void Observe();
  void ObserveInput();
  pqServer* FindServer() const;
  QString DescribeDuration(const isosurface::IsosurfaceForecast& forecast) const;

  pqSpectrumSource* Source;
  pqIsovalueChart* Chart;
  QComboBox* Quantities;
  QCheckBox* Live;
  QWidget* Tissues; ///< a button for each, shown where values are Hounsfield units
  pqTimer* FetchTimer;
  pqTimer* LiveTimer;
  vtkNew<vtkEventQtSlotConnect> Connections;
  vtkNew<vtkEventQtSlotConnect> InputConnections;
  vtkSMProxy* ObservedInput = nullptr;
  bool Stale = true; ///< the spectrum is not that of what the panel shows
  bool InUndoSet = false;
};

#endif
