// realtime
