// SPDX-License-Identifier: BSD-3-Clause
#include "pqResolutionWidget.h"

#include "pqCoreUtilities.h"
#include "vtkCommand.h"
#include "vtkSMIntRangeDomain.h"
#include "vtkSMProperty.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QSignalBlocker>

#include <algorithm>
#include <cmath>

pqResolutionWidget::pqResolutionWidget(vtkSMProxy* proxy, vtkSMProperty* property, QWidget* parent)
  : Superclass(proxy, parent)
  , Levels(new QComboBox(this))
{
  this->setProperty(property);
  this->Levels->setObjectName("Levels");
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(this->Levels, 1);
  this->ListLevels();
  QObject::connect(this->Levels, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
    &pqResolutionWidget::levelChanged);
  pqCoreUtilities::connect(property, vtkCommand::DomainModifiedEvent, this, SLOT(ListLevels()));
  this->addPropertyLink(this, "level", SIGNAL(levelChanged()), property);
}

int pqResolutionWidget::GetLevel() const
{
  return std::max(0, this->Levels->currentIndex());
}

void pqResolutionWidget::SetLevel(int level)
{
  // A script may have asked for more than there are, which gives the coarsest one.
  for (int next = this->Levels->count(); next <= level; ++next)
  {
    this->Levels->addItem(next == 0 ? tr("full") : QString("1/%1").arg(std::ldexp(1.0, next)));
  }
  this->Levels->setCurrentIndex(level);
}

int pqResolutionWidget::GetCoarsest() const
{
  return this->Levels->count() - 1;
}

void pqResolutionWidget::ListLevels()
{
  auto* range = this->Superclass::property()->FindDomain<vtkSMIntRangeDomain>();
  const int coarsest = range && range->GetMaximumExists(0) ? range->GetMaximum(0) : 0;
  const int level = this->GetLevel();
  const QSignalBlocker blocker(this->Levels);
  this->Levels->clear();
  this->SetLevel(std::max(coarsest, level));
  this->SetLevel(level);
}
