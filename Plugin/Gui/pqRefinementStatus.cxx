// SPDX-License-Identifier: BSD-3-Clause
#include "pqRefinementStatus.h"

#include "CountWords.h"

#include "pqApplicationCore.h"
#include "pqSettings.h"

#include <QAction>
#include <QMenu>

#include <cmath>

using isosurface::Refinement;

namespace
{
const char* const CoarseFirstSetting = "ScalableIsosurface/CoarseSurfacesFirst";
} // namespace

pqRefinementStatus::pqRefinementStatus(QWidget* parent)
  : Superclass(parent)
  , CoarseFirst(new QAction(tr("Coarse surfaces first"), this))
  , Stop(new QAction(tr("Stop refining"), this))
{
  this->setObjectName("RefinementStatus");
  this->setAutoRaise(true);
  this->setPopupMode(QToolButton::InstantPopup);
  this->setToolButtonStyle(Qt::ToolButtonTextOnly);
  this->setToolTip(
    tr("Isosurfaces and slices of blocked volumes are shown coarse first, then exactly."));
  pqSettings* settings = pqApplicationCore::instance()->settings();
  this->CoarseFirst->setObjectName("CoarseFirst");
  this->CoarseFirst->setCheckable(true);
  this->CoarseFirst->setChecked(settings->value(CoarseFirstSetting, true).toBool());
  this->Stop->setObjectName("StopRefining");
  this->Stop->setEnabled(false);
  QObject::connect(this->CoarseFirst, &QAction::toggled, this,
    [](bool coarse)
    { pqApplicationCore::instance()->settings()->setValue(CoarseFirstSetting, coarse); });
  QObject::connect(this->Stop, &QAction::triggered, this, &pqRefinementStatus::stopped);
  auto* menu = new QMenu(this);
  menu->setObjectName("Menu");
  menu->addAction(this->Stop);
  menu->addAction(this->CoarseFirst);
  this->setMenu(menu);
  this->hide();
}

bool pqRefinementStatus::IsCoarseFirst() const
{
  return this->CoarseFirst->isChecked();
}

void pqRefinementStatus::ShowBegin()
{
  this->Stop->setEnabled(true);
  this->show();
}

void pqRefinementStatus::ShowRefinement(const Refinement& report)
{
  const QString triangles = report.Triangles > 0
    ? tr(" of about %1 triangles").arg(isosurface::FormatCount(report.Triangles))
    : QString(); // of a slice
  this->setText(tr("%1, refining to %2: %3 %%4")
                  .arg(isosurface::FormatResolution(report.ShownLevel))
                  .arg(isosurface::FormatResolution(report.FinalLevel))
                  .arg(std::floor(100 * report.Share))
                  .arg(triangles));
  this->ShowBegin();
}

void pqRefinementStatus::ShowGrowth(const Refinement& report)
{
  const double percent = std::floor(100 * report.Share);
  this->setText(report.Share <= 0 ? QString()
      : percent < 1               ? tr("Less than 1 % exact")
                                  : tr("%1 % exact").arg(percent));
  this->ShowBegin();
}

void pqRefinementStatus::ShowEnd(int level, bool stopped)
{
  this->Stop->setEnabled(false);
  const QString resolution = isosurface::FormatResolution(level);
  this->setText(stopped ? tr("%1, refining was stopped").arg(resolution) : resolution);
  this->show();
}

void pqRefinementStatus::Clear()
{
  this->Stop->setEnabled(false);
  this->hide();
}
