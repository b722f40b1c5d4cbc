/* What the app calls of cFE 7, written from its documentation for the tests: this is not NASA's header. */
#ifndef CFE_H
#define CFE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t int32, CFE_Status_t;
typedef uint16_t uint16, CFE_MSG_FcnCode_t;
typedef uint32_t uint32, CFE_SB_MsgId_t, CFE_SB_PipeId_t, CFE_TBL_Handle_t;
typedef size_t CFE_MSG_Size_t;
typedef int32 (*CFE_TBL_CallbackFuncPtr_t)(void *table);

enum { CFE_SUCCESS = 0, CFE_TBL_INFO_UPDATED = 0x4C000001, CFE_SB_INVALID_MSG_ID = 0, CFE_SB_PEND_FOREVER = -1 };
enum { CFE_TBL_OPT_DEFAULT = 0, CFE_EVS_EventFilter_BINARY = 0 };
enum { CFE_ES_RunStatus_APP_RUN = 1, CFE_ES_RunStatus_APP_EXIT = 2, CFE_ES_RunStatus_APP_ERROR = 3 };
enum { CFE_EVS_EventType_INFORMATION = 2, CFE_EVS_EventType_ERROR = 3 };
typedef enum { CFE_TBL_SRC_FILE, CFE_TBL_SRC_ADDRESS } CFE_TBL_SrcEnum_t;

typedef struct { CFE_SB_MsgId_t id; CFE_MSG_Size_t size; CFE_MSG_FcnCode_t code; } CFE_MSG_Message_t;
typedef struct { CFE_MSG_Message_t Msg; } CFE_MSG_CommandHeader_t, CFE_MSG_TelemetryHeader_t, CFE_SB_Buffer_t;
#define CFE_MSG_PTR(header) (&(header).Msg)
#define CFE_SB_ValueToMsgId(id) (id)
#define CFE_SB_MsgIdToValue(id) (id)

bool CFE_ES_RunLoop(uint32 *status);
void CFE_ES_ExitApp(uint32 status);
CFE_Status_t CFE_EVS_Register(const void *filters, uint16 count, uint16 scheme);
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char *format, ...);
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *pipe, uint16 depth, const char *name);
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t pipe);
CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **buffer, CFE_SB_PipeId_t pipe, int32 timeout);
CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *message, bool origination);
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *message);
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *message, CFE_SB_MsgId_t id, CFE_MSG_Size_t size);
CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *message, CFE_SB_MsgId_t *id);
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *message, CFE_MSG_Size_t *size);
CFE_Status_t CFE_MSG_GetFcnCode(const CFE_MSG_Message_t *message, CFE_MSG_FcnCode_t *code);
CFE_Status_t CFE_TBL_Register(CFE_TBL_Handle_t *table, const char *name, size_t size, uint16 options,
                              CFE_TBL_CallbackFuncPtr_t validate);
CFE_Status_t CFE_TBL_Load(CFE_TBL_Handle_t table, CFE_TBL_SrcEnum_t source, const void *data);
CFE_Status_t CFE_TBL_Manage(CFE_TBL_Handle_t table);
CFE_Status_t CFE_TBL_GetAddress(void **address, CFE_TBL_Handle_t table);
CFE_Status_t CFE_TBL_ReleaseAddress(CFE_TBL_Handle_t table);

#endif
