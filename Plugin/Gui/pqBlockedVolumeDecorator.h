// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqBlockedVolumeDecorator
 * @brief   shows a property only of filters whose input is a blocked volume
 *
 * In a panel: PropertyWidgetDecorator type="BlockedVolume" at a property of levels, say, which image
 * data does not have.
 */

#ifndef pqBlockedVolumeDecorator_h
#define pqBlockedVolumeDecorator_h

#include "pqPropertyWidgetDecorator.h"

class vtkSMProxy;

class pqBlockedVolumeDecorator : public pqPropertyWidgetDecorator
{
  Q_OBJECT
  typedef pqPropertyWidgetDecorator Superclass;

public:
  pqBlockedVolumeDecorator(vtkPVXMLElement* xml, pqPropertyWidget* parent);

  bool canShowWidget(bool showAdvanced) const override;

  /// Whether a proxy reads blocked volumes, or files of any size as such.
  static bool IsReader(vtkSMProxy* proxy);
  /// Whether a filter stands straight behind such a reader, or behind filters that pass it on.
  static bool IsBehindReader(vtkSMProxy* filter);
};

#endif
