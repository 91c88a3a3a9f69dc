// Handlers of a session's requests. A handler only changes the session's state and never sleeps or waits.
// Loading, saving and single steps become DueWork for the session's loop.
#pragma once

namespace turgor {

struct SessionThread;

/// Handles requests in order. Stops after a request that creates due work.
void handle_requests(SessionThread& session);

}  // namespace turgor
