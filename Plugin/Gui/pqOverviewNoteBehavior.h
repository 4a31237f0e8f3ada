// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqOverviewNoteBehavior
 * @brief   tells which level of a blocked volume a stock filter has got
 *
 * Filters other than the plugin's own get the finest level that fits the reader's memory limit. If
 * that is not the volume itself, a line above the properties of such a filter says so, and names the
 * filter that is not limited.
 *
 * ParaView makes the one object when the plugin is loaded into its window.
 */

#ifndef pqOverviewNoteBehavior_h
#define pqOverviewNoteBehavior_h

#include <QObject>
#include <QPointer>

class QLabel;

class pqOverviewNoteBehavior : public QObject
{
  Q_OBJECT

public:
  using QObject::QObject;

  void OnStartup();
  void OnShutdown() {}

private Q_SLOTS:
  void Update();

private:
  QLabel* FindLine();

  QPointer<QLabel> Line; ///< the panel's
};

#endif
