// SPDX-License-Identifier: BSD-3-Clause
#include "pqIsovaluePropertyWidget.h"

#include "CountWords.h"
#include "Tissues.h"
#include "pqExtractionForecast.h"
#include "pqIsovalueChart.h"
#include "pqSpectrumSource.h"

#include "pqActiveObjects.h"
#include "pqApplicationCore.h"
#include "pqDataRepresentation.h"
#include "pqOutputPort.h"
#include "pqPipelineSource.h"
#include "pqPropertiesPanel.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqSettings.h"
#include "pqTimeKeeper.h"
#include "pqTimer.h"
#include "pqUndoStack.h"
#include "pqView.h"
#include "vtkCommand.h"
#include "vtkEventQtSlotConnect.h"
#include "vtkSMDoubleRangeDomain.h"
#include "vtkSMIsosurfaceRepresentationProxy.h"
#include "vtkSMPVRepresentationProxy.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMSession.h"
#include "vtkSMSourceProxy.h"
#include "vtkSMUncheckedPropertyHelper.h"
#include "vtkScalarsToColors.h"

#include <QCheckBox>
#include <QComboBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QPixmap>
#include <QStyle>
#include <QToolButton>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

using isosurface::IsosurfaceForecast;
using Quantity = isosurface::SpectrumCurve::Quantity;

namespace
{

/// While a server is at work, it is asked again after this.
constexpr int RetryMilliseconds = 50;

const char* const LiveSetting = "ScalableIsosurface/LiveIsovalues";

/// Where a level above 0 is contoured, a quarter of the triangles and an eighth of the bytes a
/// level, about.
IsosurfaceForecast ScaleToLevel(IsosurfaceForecast forecast, int level)
{
  forecast.Triangles /= std::pow(4.0, level);
  forecast.Bytes /= std::pow(8.0, level);
  return forecast;
}

} // namespace

pqIsovaluePropertyWidget::pqIsovaluePropertyWidget(
  vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(property, proxy, parent)
  , Source(new pqSpectrumSource(proxy, this))
  , Chart(new pqIsovalueChart(this))
  , Quantities(new QComboBox(this))
  , Live(new QCheckBox(tr("Live"), this))
  , Tissues(new QWidget(this))
  , FetchTimer(new pqTimer(this))
  , LiveTimer(new pqTimer(this))
{
  this->LayOut();
  this->FetchTimer->setSingleShot(true);
  this->LiveTimer->setSingleShot(true);
  this->Chart->SetDurationWords(
    [this](const IsosurfaceForecast& forecast) { return this->DescribeDuration(forecast); });
  this->addPropertyLink(this->Chart, "scalars", SIGNAL(isovaluesChanged()), property);
  this->Observe();
  this->UpdateColors();
}

pqIsovaluePropertyWidget::~pqIsovaluePropertyWidget()
{
  this->EndDrag();
}

void pqIsovaluePropertyWidget::LayOut()
{
  // The superclass has put the list and its buttons into a row.
  auto* row = new QHBoxLayout;
  row->setSpacing(this->layout()->spacing());
  while (QLayoutItem* item = this->layout()->takeAt(0))
  {
    const Qt::Alignment alignment = item->alignment();
    row->addWidget(item->widget(), alignment ? 0 : 1, alignment);
    delete item;
  }
  delete this->layout();
  if (auto* range = this->findChild<QLabel*>("ScalarRangeLabel"))
  {
    range->setWordWrap(true); // in one line, it is wider than the panel
  }

  this->Chart->setObjectName("IsovalueChart");
  this->Quantities->setObjectName("SpectrumQuantity");
  this->Quantities->addItem(tr("Triangles"), static_cast<int>(Quantity::Triangles));
  this->Quantities->addItem(tr("Area"), static_cast<int>(Quantity::Area));
  this->Quantities->addItem(tr("Blocks to read"), static_cast<int>(Quantity::ActiveBlocks));
  this->Quantities->addItem(tr("Bytes to read"), static_cast<int>(Quantity::Bytes));
  this->Quantities->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  // A tooltip of the chart would cover its readout.
  this->Quantities->setToolTip(
    tr("<p>The quantity that the chart shows over the isovalue: the contour "
       "spectrum. In grey how often values occur. Drag a handle to move its "
       "isovalue, double-click to add one, press Delete to remove it. The "
       "arrow keys move it by a fine step, the wheel zooms, Home shows "
       "all.</p>"));
  this->Live->setObjectName("Live");
  this->Live->setToolTip(tr("Whether surfaces follow while a handle is dragged, without Apply."));
  this->Live->setChecked(
    pqApplicationCore::instance()->settings()->value(LiveSetting, false).toBool());

  this->LayOutTissues();

  auto* choices = new QHBoxLayout;
  choices->setSpacing(row->spacing());
  choices->addWidget(this->Live);
  choices->addWidget(this->Quantities, 1);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(0, 0, 0, 0);
  column->setSpacing(row->spacing());
  column->addWidget(this->Chart);
  column->addLayout(choices);
  column->addWidget(this->Tissues);
  column->addLayout(row);
}

void pqIsovaluePropertyWidget::LayOutTissues()
{
  auto* row = new QHBoxLayout(this->Tissues);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(2);
  for (const isosurface::Tissue& tissue : isosurface::Tissues)
  {
    auto* button = new QToolButton(this->Tissues);
    button->setObjectName(tissue.Name);
    button->setText(tr(tissue.Name));
    button->setToolTip(
      tr("The isosurface at %1 HU, or not: usual for this tissue in a CT.").arg(tissue.Isovalue));
    button->setCheckable(true);
    button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed); // no wider than the panel
    QPixmap color(8, 12);
    color.fill(QColor::fromRgbF(tissue.Color[0], tissue.Color[1], tissue.Color[2]));
    button->setIcon(color);
    button->setIconSize(color.size());
    button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
    QObject::connect(button, &QToolButton::clicked, this,
      [this, isovalue = tissue.Isovalue] { this->ToggleIsovalue(isovalue); });
    row->addWidget(button, button->sizeHint().width()); // "Muscle" is wider than others
  }
  this->Tissues->setObjectName("Tissues");
  this->Tissues->hide();
}

void pqIsovaluePropertyWidget::ToggleIsovalue(double isovalue)
{
  QVariantList isovalues = this->Chart->GetIsovalues();
  if (!isovalues.removeOne(isovalue))
  {
    const auto above = std::find_if(isovalues.begin(), isovalues.end(),
      [isovalue](const QVariant& other) { return other.toDouble() > isovalue; });
    isovalues.insert(above, isovalue);
  }
  this->Chart->ChangeIsovalues(isovalues);
}

void pqIsovaluePropertyWidget::UpdateTissues()
{
  const std::vector<double> isovalues =
    vtkSMUncheckedPropertyHelper(this->property()).GetDoubleArray();
  for (const isosurface::Tissue& tissue : isosurface::Tissues)
  {
    const bool isShown =
      std::find(isovalues.begin(), isovalues.end(), tissue.Isovalue) != isovalues.end();
    this->Tissues->findChild<QToolButton*>(tissue.Name)->setChecked(isShown);
  }
}

void pqIsovaluePropertyWidget::Observe()
{
  QObject::connect(
    this->FetchTimer, &QTimer::timeout, this, &pqIsovaluePropertyWidget::FetchSpectrum);
  QObject::connect(this->LiveTimer, &QTimer::timeout, this, &pqIsovaluePropertyWidget::ApplyNow);
  QObject::connect(
    this->Chart, &pqIsovalueChart::dragStarted, this, &pqIsovaluePropertyWidget::BeginDrag);
  QObject::connect(
    this->Chart, &pqIsovalueChart::dragFinished, this, &pqIsovaluePropertyWidget::EndDrag);
  QObject::connect(
    this->Chart, &pqIsovalueChart::isovaluesChanged, this, &pqIsovaluePropertyWidget::FollowIfLive);
  QObject::connect(this->Quantities, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
    [this](int index) {
      this->Chart->SetQuantity(static_cast<Quantity>(this->Quantities->itemData(index).toInt()));
    });
  QObject::connect(this->Live, &QCheckBox::toggled, this,
    [](bool live) { pqApplicationCore::instance()->settings()->setValue(LiveSetting, live); });
  QObject::connect(
    this->Source, &pqSpectrumSource::counted, this, &pqIsovaluePropertyWidget::ExpectSpectrum);

  for (const char* name : { "Input", "SelectInputScalars", "Component" })
  {
    vtkSMProperty* property = this->proxy()->GetProperty(name);
    this->Connections->Connect(
      property, vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(ExpectSpectrum()));
    this->Connections->Connect(property, vtkCommand::ModifiedEvent, this, SLOT(ExpectSpectrum()));
  }
  this->Connections->Connect(
    this->property(), vtkCommand::UncheckedPropertyModifiedEvent, this, SLOT(UpdateTissues()));
  this->Connections->Connect(
    this->proxy(), vtkCommand::UpdateDataEvent, this, SLOT(LearnFromSurface()));
  if (pqServer* server = this->FindServer())
  {
    QObject::connect(server->getTimeKeeper(), SIGNAL(timeChanged()), this, SLOT(ExpectSpectrum()));
  }
  QObject::connect(&pqActiveObjects::instance(), &pqActiveObjects::viewChanged, this,
    [this](pqView* view)
    {
      if (view)
      {
        QObject::connect(view, &pqView::endRender, this, &pqIsovaluePropertyWidget::UpdateColors,
          Qt::UniqueConnection);
      }
      this->UpdateColors();
    });
  if (pqView* view = pqActiveObjects::instance().activeView())
  {
    QObject::connect(view, &pqView::endRender, this, &pqIsovaluePropertyWidget::UpdateColors,
      Qt::UniqueConnection);
  }
}

void pqIsovaluePropertyWidget::ObserveInput()
{
  vtkSMProxy* input = vtkSMPropertyHelper(this->proxy(), "Input").GetAsProxy();
  if (input != this->ObservedInput)
  {
    this->InputConnections->Disconnect();
    this->ObservedInput = input;
    if (input)
    {
      this->InputConnections->Connect(
        input, vtkCommand::UpdateDataEvent, this, SLOT(ExpectSpectrum()));
    }
  }
}

pqServer* pqIsovaluePropertyWidget::FindServer() const
{
  return pqApplicationCore::instance()->getServerManagerModel()->findServer(
    this->proxy()->GetSession());
}

void pqIsovaluePropertyWidget::select()
{
  this->Superclass::select();
  this->UpdateColors();
}

void pqIsovaluePropertyWidget::showEvent(QShowEvent* event)
{
  this->Superclass::showEvent(event);
  if (this->Stale)
  {
    this->FetchTimer->start(0);
  }
}

void pqIsovaluePropertyWidget::ExpectSpectrum()
{
  this->Stale = true;
  if (this->isVisible())
  {
    this->FetchTimer->start(0);
  }
}

void pqIsovaluePropertyWidget::FetchSpectrum()
{
  pqServer* server = this->FindServer();
  if (!server || !this->isVisible() || !this->Stale)
  {
    return;
  }
  if (server->isProgressPending() || this->Chart->IsDragging())
  {
    this->FetchTimer->start(RetryMilliseconds);
    return;
  }
  this->ObserveInput();
  this->proxy()->UpdatePropertyInformation(this->proxy()->GetProperty("Unit"));
  this->Tissues->setVisible(
    isosurface::AreTissuesIn(vtkSMPropertyHelper(this->proxy(), "Unit").GetAsString()));
  this->UpdateTissues();
  this->Stale = false;
  this->Chart->SetSpectrum(this->Source->Fetch(server->getTimeKeeper()->getTime()));
  if (this->Chart->GetSpectrum().IsEmpty())
  {
    this->Chart->SetMessage(this->Source->IsCounting() ? tr("The samples are being counted.")
                                                       : tr("There is no spectrum of this array."));
  }
  this->Chart->SetStored(this->Source->IsStored());
  this->Chart->SetShare(this->Source->GetShare());
  if (this->Chart->GetSpectrum().IsEmpty())
  {
    auto* range = this->property()->FindDomain<vtkSMDoubleRangeDomain>();
    if (range && range->GetMinimumExists(0) && range->GetMaximumExists(0))
    {
      this->Chart->SetRange(range->GetMinimum(0), range->GetMaximum(0));
    }
  }
}

void pqIsovaluePropertyWidget::LearnFromSurface()
{
  if (pqServer* server = this->FindServer())
  {
    pqExtractionForecast::Of(server)->Learn(vtkSMSourceProxy::SafeDownCast(this->proxy()));
    this->Chart->update();
  }
}

QString pqIsovaluePropertyWidget::DescribeDuration(const IsosurfaceForecast& forecast) const
{
  pqServer* server = this->FindServer();
  if (!server)
  {
    return QString();
  }
  const pqExtractionForecast* times = pqExtractionForecast::Of(server);
  vtkSMProperty* level = this->proxy()->GetProperty("Level");
  const IsosurfaceForecast scaled =
    ScaleToLevel(forecast, level ? vtkSMUncheckedPropertyHelper(level).GetAsInt() : 0);
  const double fromMemory = times->PredictFromMemory(scaled);
  const double fromDisk = this->Source->IsStored() ? times->PredictFromDisk(scaled) : fromMemory;
  if (fromDisk < 1.2 * fromMemory)
  {
    return tr("about %1").arg(isosurface::FormatSeconds(fromMemory));
  }
  return tr("about %1, from disk %2")
    .arg(isosurface::FormatSeconds(fromMemory))
    .arg(isosurface::FormatSeconds(fromDisk));
}

void pqIsovaluePropertyWidget::UpdateColors()
{
  const auto* model = pqApplicationCore::instance()->getServerManagerModel();
  auto* source = model->findItem<pqPipelineSource*>(this->proxy());
  pqView* view = pqActiveObjects::instance().activeView();
  pqDataRepresentation* shown =
    source && view ? source->getOutputPort(0)->getRepresentation(view) : nullptr;
  vtkSMProxy* display = shown ? shown->getProxy() : nullptr;
  if (!display || !display->GetProperty("DiffuseColor"))
  {
    this->Chart->SetColors(QVector<QColor>());
    return;
  }
  vtkScalarsToColors* map = nullptr;
  auto* representation = vtkSMPVRepresentationProxy::SafeDownCast(display);
  if (representation && representation->GetUsingScalarColoring())
  {
    vtkSMProxy* table = vtkSMPropertyHelper(display, "LookupTable").GetAsProxy();
    if (!table || !vtkSMIsosurfaceRepresentationProxy::ShowsIsovalues(display, this->proxy()))
    {
      this->Chart->SetColors(QVector<QColor>());
      return;
    }
    map = vtkScalarsToColors::SafeDownCast(table->GetClientSideObject());
  }
  double color[3];
  vtkSMPropertyHelper(display, "DiffuseColor").Get(color, 3);
  const std::vector<double> applied =
    vtkSMPropertyHelper(this->proxy(), "ContourValues").GetDoubleArray();
  QVector<QColor> colors;
  for (const QVariant& isovalue : this->Chart->GetIsovalues())
  {
    const auto place = static_cast<std::size_t>(colors.size());
    double value = isovalue.toDouble();
    // One that is not applied has no category yet. Where it was moved, it will get that of its old value.
    if (map && map->GetIndexedLookup() && map->GetAnnotatedValueIndex(value) < 0 &&
      place < applied.size())
    {
      value = applied[place];
    }
    if (map)
    {
      map->GetColor(value, color);
    }
    colors.push_back(QColor::fromRgbF(color[0], color[1], color[2]));
  }
  this->Chart->SetColors(colors);
}

void pqIsovaluePropertyWidget::BeginDrag()
{
  if (!this->InUndoSet)
  {
    this->InUndoSet = true;
    BEGIN_UNDO_SET(tr("Move Isovalue"));
  }
}

void pqIsovaluePropertyWidget::EndDrag()
{
  if (this->InUndoSet)
  {
    // What the last move has asked for belongs to the same step.
    if (this->LiveTimer->isActive())
    {
      this->LiveTimer->stop();
      this->ApplyNow();
    }
    this->InUndoSet = false;
    END_UNDO_SET();
  }
}

void pqIsovaluePropertyWidget::FollowIfLive()
{
  this->UpdateColors();
  if (this->Live->isChecked() && !this->LiveTimer->isActive())
  {
    this->LiveTimer->start(0);
  }
}

void pqIsovaluePropertyWidget::ApplyNow()
{
  const pqServer* server = this->FindServer();
  if (server && server->isProgressPending())
  {
    this->LiveTimer->start(RetryMilliseconds);
    return;
  }
  for (QWidget* ancestor = this->parentWidget(); ancestor; ancestor = ancestor->parentWidget())
  {
    if (auto* panel = qobject_cast<pqPropertiesPanel*>(ancestor))
    {
      panel->apply();
      return;
    }
  }
  this->apply();
}
