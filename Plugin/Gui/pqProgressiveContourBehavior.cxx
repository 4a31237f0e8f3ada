// SPDX-License-Identifier: BSD-3-Clause
#include "pqProgressiveContourBehavior.h"

#include "pqApplicationCore.h"
#include "pqPipelineSource.h"
#include "pqServer.h"
#include "pqServerManagerModel.h"
#include "pqTimer.h"
#include "vtkSMPropertyHelper.h"
#include "vtkSMProxy.h"

#include <QGuiApplication>

#include <algorithm>
#include <cstring>

namespace
{

bool IsProgressive(const pqPipelineSource* source)
{
  vtkSMProxy* proxy = source->getProxy();
  return std::strcmp(proxy->GetXMLName(), "StabbingContour") == 0 &&
    vtkSMPropertyHelper(proxy, "Progressive").GetAsInt() != 0;
}

bool IsFinal(vtkSMProxy* proxy)
{
  proxy->UpdatePropertyInformation(proxy->GetProperty("Final"));
  return vtkSMPropertyHelper(proxy, "Final").GetAsInt() != 0;
}

bool IsAnyServerWorking(const pqServerManagerModel* model)
{
  const QList<pqServer*> servers = model->findItems<pqServer*>();
  return std::any_of(servers.begin(), servers.end(),
    [](const pqServer* server) { return server->isProgressPending(); });
}

} // namespace

//------------------------------------------------------------------------------
pqProgressiveContourBehavior::pqProgressiveContourBehavior(QObject* parent)
  : QObject(parent)
  , Timer(new pqTimer(this))
{
  this->Timer->setSingleShot(true);
  this->Timer->setInterval(RestMilliseconds);
  QObject::connect(this->Timer, &QTimer::timeout, this, &pqProgressiveContourBehavior::Refine);
}

//------------------------------------------------------------------------------
pqProgressiveContourBehavior::~pqProgressiveContourBehavior() = default;

//------------------------------------------------------------------------------
void pqProgressiveContourBehavior::OnStartup()
{
  pqServerManagerModel* model = pqApplicationCore::instance()->getServerManagerModel();
  QObject::connect(
    model, &pqServerManagerModel::sourceAdded, this, &pqProgressiveContourBehavior::Observe);
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    this->Observe(source);
  }
}

//------------------------------------------------------------------------------
void pqProgressiveContourBehavior::OnShutdown()
{
  this->Timer->stop();
}

//------------------------------------------------------------------------------
void pqProgressiveContourBehavior::Observe(pqPipelineSource* source)
{
  QObject::connect(source,
    static_cast<void (pqPipelineSource::*)(pqPipelineSource*)>(&pqPipelineSource::dataUpdated),
    this, &pqProgressiveContourBehavior::WaitForRest);
}

//------------------------------------------------------------------------------
void pqProgressiveContourBehavior::WaitForRest(pqPipelineSource* source)
{
  if (IsProgressive(source))
  {
    this->Timer->start();
  }
}

//------------------------------------------------------------------------------
void pqProgressiveContourBehavior::Refine()
{
  pqApplicationCore* application = pqApplicationCore::instance();
  const pqServerManagerModel* model = application->getServerManagerModel();
  if (QGuiApplication::mouseButtons() != Qt::NoButton || IsAnyServerWorking(model))
  {
    this->Timer->start();
    return;
  }
  bool refined = false;
  for (pqPipelineSource* source : model->findItems<pqPipelineSource*>())
  {
    if (IsProgressive(source) && !IsFinal(source->getProxy()))
    {
      source->getProxy()->InvokeCommand("Refine");
      refined = true;
    }
  }
  if (refined)
  {
    application->render();
  }
}
