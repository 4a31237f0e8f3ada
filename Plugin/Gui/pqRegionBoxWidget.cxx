// SPDX-License-Identifier: BSD-3-Clause
#include "pqRegionBoxWidget.h"

#include "pqCoreUtilities.h"
#include "vtkCommand.h"
#include "vtkSMProperty.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

pqRegionBoxWidget::pqRegionBoxWidget(vtkSMProxy* proxy, vtkSMPropertyGroup* group, QWidget* parent)
  : Superclass(proxy, group, parent)
{
  if (vtkSMProperty* input = proxy->GetProperty("Input"))
  {
    pqCoreUtilities::connect(input, vtkCommand::ModifiedEvent, this, SLOT(FollowInput()));
  }
  this->FollowInput();
}

void pqRegionBoxWidget::FollowInput()
{
  vtkSMProperty* input = this->proxy()->GetProperty("Input");
  this->setDataSource(input ? vtkSMPropertyHelper(input).GetAsProxy() : this->proxy());
}
