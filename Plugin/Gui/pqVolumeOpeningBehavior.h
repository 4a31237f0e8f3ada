// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   pqVolumeOpeningBehavior
 * @brief   opens folders of volumes, and proposes our readers for files of any name
 *
 * - File > Open Volume Folder... asks for a folder of the active server.
 * - Where ParaView asks for a reader of a file (All Files), ours is selected if it reads the file.
 *
 * ParaView makes the one object when the plugin is loaded into its window.
 */

#ifndef pqVolumeOpeningBehavior_h
#define pqVolumeOpeningBehavior_h

#include <QObject>

class QDialog;

class pqVolumeOpeningBehavior : public QObject
{
  Q_OBJECT

public:
  using QObject::QObject;

  void OnStartup();
  void OnShutdown();

protected:
  /// Waits for ParaView's question for a reader.
  bool eventFilter(QObject* object, QEvent* event) override;

private Q_SLOTS:
  void AddToMenu();
  void OpenFolder();

private:
  void Propose(const QDialog* question) const;
};

#endif
