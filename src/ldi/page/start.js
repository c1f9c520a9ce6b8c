// Shows the photo once its data is there; without them the poster stays.
window.QuadraturaViewer.start(window.QuadraturaPhoto);
