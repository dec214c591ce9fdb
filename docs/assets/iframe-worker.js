// Browsers give pages that are opened as files no workers.  The search runs in one, so here it gets a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super()
      this.frame = document.createElement("iframe")
      this.frame.hidden = true
      this.frame.srcdoc = "<!doctype html><title>search</title>"
      this.inside = new Promise((resolve, reject) => {
        this.frame.onload = () => {
          const inside = this.frame.contentWindow
          inside.postMessage = data => queueMicrotask(() => {
            const answer = new MessageEvent("message", { data })
            this.onmessage?.(answer)
            this.dispatchEvent(answer)
          })
          const script = inside.document.createElement("script")
          script.src = url
          script.onload = () => resolve(inside)
          script.onerror = () => reject(new Error(`${url} cannot be loaded`))
          inside.document.head.append(script)
        }
      })
      document.body.append(this.frame)
    }

    postMessage(data) {
      this.inside.then(inside => inside.dispatchEvent(new MessageEvent("message", { data })))
    }

    terminate() {
      this.frame.remove()
    }
  }
}
