; What tests/editors.sh and tests/editors_round_trip.sh have GIMP do. Script-Fu, because Debian's GIMP
; 2.10 has no Python.

(define (opened file)
  (car (gimp-file-load RUN-NONINTERACTIVE file file)))

; As PSD or XCF, by its name.
(define (save-layered image file)
  (gimp-file-save RUN-NONINTERACTIVE image (car (gimp-image-get-active-layer image)) file file))

; Opens a file, fills a square of one layer with a colour, and saves the document as another.
(define (paint-and-save in name out)
  (let* ((image (opened in))
         (layer (car (gimp-image-get-layer-by-name image name)))
         (offsets (gimp-drawable-offsets layer)))
    (gimp-image-select-rectangle image CHANNEL-OP-REPLACE (+ 3 (car offsets)) (+ 4 (cadr offsets)) 12 11)
    (gimp-context-set-foreground '(255 0 200))
    (gimp-drawable-edit-fill layer FILL-FOREGROUND)
    (gimp-selection-none image)
    (save-layered image out)
    (gimp-image-delete image)))

; Opens a PSD and saves it as it is.
(define (save-again in out)
  (let ((image (opened in)))
    (save-layered image out)
    (gimp-image-delete image)))

; Saves what is to be seen as a PNG.
(define (save-picture in out)
  (let* ((image (opened in))
         (layer (car (gimp-image-merge-visible-layers image CLIP-TO-IMAGE))))
    (file-png-save RUN-NONINTERACTIVE image layer out out FALSE 1 FALSE FALSE FALSE FALSE FALSE)
    (gimp-image-delete image)))

; Opens a file, gives its pixels another precision, and saves it.
(define (save-with-precision in precision out)
  (let ((image (opened in)))
    (if (not (= precision (car (gimp-image-get-precision image))))
        (gimp-image-convert-precision image precision))
    (save-layered image out)
    (gimp-image-delete image)))

; Changes what can be changed of a layer besides its pixels, and saves the document as BASE.xcf and
; BASE.psd, then in another precision as BASE16.xcf and BASE16.psd.
(define (change-and-save in precision base)
  (let* ((image (opened in))
         (group (aref (cadr (gimp-image-get-layers image)) 0))
         (layer (aref (cadr (gimp-item-get-children group)) 1))
         (twin (car (gimp-layer-copy layer FALSE)))
         (mask (car (gimp-layer-create-mask layer ADD-MASK-WHITE))))
    (gimp-layer-add-mask layer mask)
    (gimp-image-select-ellipse image CHANNEL-OP-REPLACE 20 10 90 70)
    (gimp-context-set-foreground '(0 0 0))
    (gimp-drawable-edit-fill mask FILL-FOREGROUND)
    (gimp-selection-none image)
    (gimp-layer-set-opacity layer 40)
    (gimp-layer-set-mode layer LAYER-MODE-MULTIPLY)
    (gimp-image-insert-layer image twin group 0)
    (gimp-item-set-visible group FALSE)
    (gimp-image-resize image 1000 900 10 20)
    (save-layered image (string-append base ".xcf"))
    (save-layered image (string-append base ".psd"))
    (gimp-image-convert-precision image precision)
    (save-layered image (string-append base "16.xcf"))
    (save-layered image (string-append base "16.psd"))
    (gimp-image-delete image)))
