"""Method 1 on the virtual flume's recordings, beside the published tables it was printed in."""
